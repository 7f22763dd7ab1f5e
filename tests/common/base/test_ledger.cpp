#include <gmock/gmock.h>

#include <map>
#include <string>

#include "common/base/ledger.hpp"

namespace ricochet {
namespace {

TEST(ContactRecord, HasItsNumbersInTheOrderOfItsColumns) {
  ContactRecord record;
  record.gap_min_m = 1;
  record.contact_force_n = 2;
  record.contact_pressure_mean_pa = 3;
  record.principal_stress_mean_pa = 4;
  record.friction_force_n = 5;
  record.pairs_stick = 6;
  record.pairs_slip = 7;
  record.pairs_open = 8;
  record.energy_contact_j = 9;
  record.energy_friction_j = 10;
  record.contact_impulse_n_s = 11;
  record.friction_impulse_n_s = 12;
  record.friction_force_b_n = 16;
  record.friction_impulse_b_n_s = 17;
  record.contact_pressure_max_pa = 22;
  record.contact_radius_m = 23;
  record.normal_force_t_n = 18;
  record.normal_force_b_n = 19;
  record.normal_impulse_t_n_s = 20;
  record.normal_impulse_b_n_s = 21;
  record.contact_iterations = 13;
  record.contact_residual = 14;
  record.contact_unconverged = 15;
  const std::map<std::string, double> expected = {{"gap_min_m", 1},
                                                  {"contact_force_n", 2},
                                                  {"contact_pressure_mean_pa", 3},
                                                  {"principal_stress_mean_pa", 4},
                                                  {"friction_force_n", 5},
                                                  {"pairs_stick", 6},
                                                  {"pairs_slip", 7},
                                                  {"pairs_open", 8},
                                                  {"energy_contact_j", 9},
                                                  {"energy_friction_j", 10},
                                                  {"contact_impulse_n_s", 11},
                                                  {"friction_impulse_n_s", 12},
                                                  {"friction_force_b_n", 16},
                                                  {"friction_impulse_b_n_s", 17},
                                                  {"contact_pressure_max_pa", 22},
                                                  {"contact_radius_m", 23},
                                                  {"normal_force_t_n", 18},
                                                  {"normal_force_b_n", 19},
                                                  {"normal_impulse_t_n_s", 20},
                                                  {"normal_impulse_b_n_s", 21},
                                                  {"contact_iterations", 13},
                                                  {"contact_residual", 14},
                                                  {"contact_unconverged", 15}};
  std::vector<double> row = {-1.0};
  append_quantities(record, row);
  ASSERT_EQ(row.size(), 1 + contact_quantities.size());
  EXPECT_EQ(row[0], -1.0) << "what was there stays";
  std::map<std::string, double> found;
  for (std::size_t i = 0; i < contact_quantities.size(); ++i)
    found[std::string(contact_quantities[i].first)] = row[i + 1];
  EXPECT_EQ(found, expected);
}

TEST(ContactRecord, OfSeveralContactsEndsWithWhatIsToldOfEach) {
  ContactRecord record;
  record.contacts.resize(2);
  record.contacts[0].gap_min_m = 1;
  record.contacts[1].contact_force_n = 2;
  record.contacts[1].friction_impulse_b_n_s = 3;
  std::vector<double> row;
  append_quantities(record, row);
  const std::size_t all = contact_quantities.size(), each = named_contact_quantities.size();
  ASSERT_EQ(row.size(), all + 2 * each);
  for (std::size_t i = 0; i < each; ++i) {
    const auto name = named_contact_quantities[i].first;
    EXPECT_EQ(row[all + i], name == "gap_min_m" ? 1.0 : 0.0) << name;
    EXPECT_EQ(row[all + each + i], name == "contact_force_n"          ? 2.0
                                   : name == "friction_impulse_b_n_s" ? 3.0
                                                                      : 0.0)
        << name;
  }
}

/// Everything that is told of each contact is told of all together, by the same name.
TEST(ContactRecord, OfEachContactHasNumbersOfAllContacts) {
  for (const auto& [name, member] : named_contact_quantities) {
    bool found = false;
    for (const auto& [of_all, member_of_all] : contact_quantities)
      found = found || (of_all == name && member_of_all == static_cast<double ContactRecord::*>(member));
    EXPECT_TRUE(found) << name;
  }
}

}  // namespace
}  // namespace ricochet
