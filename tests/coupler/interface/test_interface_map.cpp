#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/error.hpp"
#include "coupler/interface/interface_map.hpp"

namespace ricochet::coupler {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

struct Node {
  int body;
  double x, y, mass;
};

PeerDescription description(const std::string& name, const std::string& role, const std::vector<Node>& nodes) {
  PeerDescription message;
  message.participant = name;
  message.role = *find_named<Role>(role);
  message.components = 2;
  message.bodies = {"striker", "target"};
  const int n = static_cast<int>(nodes.size());
  message.interface_body = {n, 1, {}};
  message.interface_position_m = {n, 2, {}};
  message.interface_mass_kg = {n, 1, {}};
  for (const auto& node : nodes) {
    message.interface_body.data.push_back(node.body);
    message.interface_position_m.data.insert(message.interface_position_m.data.end(), {node.x, node.y});
    message.interface_mass_kg.data.push_back(node.mass);
  }
  return message;
}

std::string refusal(const std::vector<PeerDescription>& descriptions) {
  try {
    InterfaceMap map(descriptions);
  } catch (const ProtocolError& error) {
    return error.what();
  }
  return "";
}

TEST(InterfaceMap, MatchesByBodyAndPositionInAnyOrderAndSumsMasses) {
  const auto implicit =
      description("implicit", "implicit", {{0, 0.0, 1.0, 1.0}, {0, 0.5, 1.0, 2.0}, {1, 0.0, 1.0, 4.0}});
  const auto a = description("a", "explicit", {{0, 0.5 + 1e-12, 1.0, 0.5}, {0, 0.0, 1.0 - 1e-12, 0.25}});
  const auto b = description("b", "explicit", {{1, 0.0, 1.0, 0.125}});
  const InterfaceMap map({a, implicit, b});
  EXPECT_EQ(map.nodes(), 3);
  EXPECT_EQ(map.components(), 2);
  EXPECT_THAT(map.rows(1).dofs(), ElementsAre(0, 1, 2, 3, 4, 5));
  EXPECT_THAT(map.rows(0).dofs(), ElementsAre(2, 3, 0, 1));
  EXPECT_THAT(map.rows(2).dofs(), ElementsAre(4, 5));
  EXPECT_THAT(map.mass_kg(), ElementsAre(1.25, 2.5, 4.125));
}

TEST(InterfaceMap, GatherScatterAdd) {
  const InterfaceRows rows{{2, 0}, 2};
  std::vector<double> own, shared = {1, 2, 3, 4, 5, 6};
  rows.gather(shared, own);
  EXPECT_THAT(own, ElementsAre(5, 6, 1, 2));
  rows.add(own, shared);
  EXPECT_THAT(shared, ElementsAre(2, 4, 3, 4, 10, 12));
  rows.scatter(own, shared);
  EXPECT_THAT(shared, ElementsAre(1, 2, 3, 4, 5, 6));
}

TEST(InterfaceMap, GatherScatterAddInBlocks) {
  const InterfaceRows rows{{1, 2, 0, 4}, 2};
  std::vector<double> own, shared = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10};
  rows.gather(shared, own);
  EXPECT_THAT(own, ElementsAre(3, 4, 5, 6, 1, 2, 9, 10));
  rows.add(own, shared);
  EXPECT_THAT(shared, ElementsAre(2, 4, 6, 8, 10, 12, 7, 8, 18, 20));
  rows.scatter(own, shared);
  EXPECT_THAT(shared, ElementsAre(1, 2, 3, 4, 5, 6, 7, 8, 9, 10));
}

TEST(InterfaceMap, KnowsRowsThatAreTheSharedOnes) {
  EXPECT_TRUE(InterfaceRows({0, 1, 2}, 2).all_in_order(3));
  EXPECT_TRUE(InterfaceRows().all_in_order(0));
  EXPECT_FALSE(InterfaceRows({0, 1, 2}, 2).all_in_order(4));
  EXPECT_FALSE(InterfaceRows({0, 2, 1}, 2).all_in_order(3));
}

TEST(InterfaceMap, NodeWithoutPartnerIsNamedByPosition) {
  const auto implicit = description("implicit", "implicit", {{0, 0.0, 1.0, 1.0}});
  const auto far = description("a", "explicit", {{0, 0.0, 1.0 + 1e-6, 1.0}});
  EXPECT_THAT(refusal({far, implicit}), AllOf(HasSubstr("no partner"), HasSubstr("'striker'"), HasSubstr("(0, 1) m")));
  const auto other_body = description("a", "explicit", {{1, 0.0, 1.0, 1.0}});
  EXPECT_THAT(refusal({other_body, implicit}), HasSubstr("no partner"));
}

TEST(InterfaceMap, ExactlyOneImplicitOwner) {
  const std::vector<Node> node = {{0, 0.0, 1.0, 1.0}};
  EXPECT_THAT(refusal({description("a", "explicit", node), description("b", "explicit", node)}),
              HasSubstr("integrated by 0 implicit participants"));
  EXPECT_THAT(refusal({description("a", "implicit", node), description("b", "implicit", node)}),
              HasSubstr("integrated by 2 implicit participants"));
}

TEST(InterfaceMap, MalformedDescriptionsAreRefusedByName) {
  const std::vector<Node> twice = {{0, 0.0, 1.0, 1.0}, {0, 0.0, 1.0, 1.0}};
  EXPECT_THAT(refusal({description("a", "explicit", twice), description("b", "implicit", {twice[0]})}),
              AllOf(HasSubstr("coincide"), HasSubstr("'a'")));
  auto wrong = description("a", "explicit", {{7, 0.0, 1.0, 1.0}});
  EXPECT_THAT(refusal({wrong}), HasSubstr("body number 7"));
  wrong = description("a", "explicit", {{0, 0.0, 1.0, -1.0}});
  EXPECT_THAT(refusal({wrong}), HasSubstr("negative"));
  wrong = description("a", "explicit", {{0, 0.0, 1.0, 1.0}});
  wrong.interface_mass_kg.data.clear();
  EXPECT_THAT(refusal({wrong}), HasSubstr("different shapes"));
  wrong = description("a", "explicit", {{0, 0.0, 1.0, 1.0}, {0, 0.0, 2.0, 1.0}});
  std::swap(wrong.interface_mass_kg.rows, wrong.interface_mass_kg.columns);
  EXPECT_THAT(refusal({wrong}), HasSubstr("'interface_mass_kg' is 1 x 2, expected 2 x 1"));
  wrong = description("a", "explicit", {});
  wrong.components = 1;
  EXPECT_THAT(refusal({wrong, description("b", "implicit", {})}), HasSubstr("components"));
}

TEST(InterfaceMap, NoInterfaceAtAll) {
  const InterfaceMap map({description("implicit", "implicit", {})});
  EXPECT_EQ(map.nodes(), 0);
}

TEST(InterfaceMap, SinglePointFarFromTheOrigin) {
  const auto implicit = description("implicit", "implicit", {{0, 0.0, 100.0, 1.0}});
  const auto a = description("a", "explicit", {{0, 0.0, 100.0 + 1e-9, 1.0}});
  EXPECT_EQ(InterfaceMap({a, implicit}).nodes(), 1);
}

}  // namespace
}  // namespace ricochet::coupler
