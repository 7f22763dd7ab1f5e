// Adding up what the participants know of the axial stress.
#include <gmock/gmock.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "common/base/error.hpp"
#include "coupler/results/axial_stress.hpp"

namespace ricochet::coupler {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class AxialStress : public testing::Test {
 protected:
  AxialStress()
      : results_(testing::TempDir() + "axial_stress_" + std::to_string(getpid()),
                 {"axial_stress.csv", "fields/explicit.axial_stress"}) {}
  ~AxialStress() override { std::filesystem::remove_all(results_.path()); }
  void write(const std::string& participant, const std::string& text) const {
    std::ofstream(results_.file("fields/" + participant + ".axial_stress")) << text;
  }
  void add_up() const { add_up_axial_stress(results_, {"explicit", "implicit"}, {"steel", "carbide"}); }
  [[nodiscard]] std::string sum() const {
    add_up();
    std::ostringstream text;
    text << std::ifstream(results_.file("axial_stress.csv")).rdbuf();
    return text.str();
  }
  [[nodiscard]] std::string error() const {
    try {
      add_up();
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "no error";
  }

  ResultsDirectory results_;
};

TEST_F(AxialStress, SharesOfALayerAddUpInTheOrderOfTheBodies) {
  write("explicit", "time_s,carbide/0/1/1,steel/-2/-1/0.25\n0,1,2\n0.5,-3,4e6\n");
  write("implicit", "time_s,steel/-2/-1/0.75,steel/-1/0/1\n0,10,20\n0.5,1e6,40\n");
  EXPECT_EQ(sum(), "time_s,steel/-2/-1,steel/-1/0,carbide/0/1\n0,12,20,1\n0.5,5e+06,40,-3\n");
  EXPECT_FALSE(std::filesystem::exists(results_.file("fields/explicit.axial_stress")));
}

TEST_F(AxialStress, ALayerOfWhichSomethingIsMissingIsNotANumber) {
  write("implicit", "time_s,steel/-2/-1/0.75,steel/-1/0/1\n0,10,20\n");
  EXPECT_EQ(sum(), "time_s,steel/-2/-1,steel/-1/0\n0,nan,20\n");
}

TEST_F(AxialStress, EndsWithTheLastTimeThatAllHaveTold) {
  write("explicit", "time_s,carbide/0/1/1\n0,1\n1,2\n2,3");  // killed within a line
  write("implicit", "time_s,steel/-1/0/1\n0,4\n1,5\n2,6\n");
  EXPECT_EQ(sum(), "time_s,steel/-1/0,carbide/0/1\n0,4,1\n1,5,2\n");
}

TEST_F(AxialStress, NobodyToldNoFile) {
  add_up();
  EXPECT_FALSE(std::filesystem::exists(results_.file("axial_stress.csv")));
}

TEST_F(AxialStress, WrongFilesAreNamedByLine) {
  write("implicit", "time_s,lead/0/1/1\n");
  EXPECT_THAT(error(), AllOf(HasSubstr("implicit.axial_stress:1"), HasSubstr("lead/0/1/1")));
  write("implicit", "time_s,steel/0/1\n");
  EXPECT_THAT(error(), HasSubstr("steel/0/1"));
  write("implicit", "time_s,steel/0/1/1\n0,x\n");
  EXPECT_THAT(error(), AllOf(HasSubstr("implicit.axial_stress:2"), HasSubstr("\"x\"")));
  write("implicit", "time_s,steel/0/1/1\n0,1,2\n");
  EXPECT_THAT(error(), HasSubstr("0,1,2"));
}

}  // namespace
}  // namespace ricochet::coupler
