// Participants that break the wire or the legal order of messages, or that end when they should not.
#include "tests/faults/fault_run.hpp"

namespace ricochet::test {
namespace {

struct Habit {
  const char* name;  ///< of the participant; fake_participant does what its name says
  int code;
  const char* status;
  std::vector<std::string> words;
  const char* transport = nullptr;  ///< over which it is possible; null: over any
};

using HabitOver = std::pair<Habit, std::string>;

void PrintTo(const HabitOver& test, std::ostream* out) { *out << test.first.name << " over " << test.second; }

constexpr auto broken = "protocol_broken", failed = "participant_failed", wrong = "scene_wrong";

const std::vector<Habit> habits = {
    {"says_nan", 5, broken, {"in window 40", "'increment' is not finite: nan at row 0"}},
    {"says_too_few_numbers", 5, broken, {"window 40", "'increment'", "its interface has 2 x 1"}},
    {"says_another_kind", 5, broken, {"sent 'accepted' while 'advance' was outstanding", "expected one of 'advanced'"}},
    {"answers_twice",
     5,
     broken,
     {"participant 'answers_twice'"}},  // out of turn, number or window, as the second one is met
    {"means_another_run", 5, broken, {"run '20200101-000000-1-deadbeef', this is run '"}},
    {"says_nonsense", 5, broken, {"in window 40"}},
    {"says_two_frames", 5, broken, {"in window 40", "a message of 2 frames, expected one"}, "zmq"},
    {"says_half", 5, broken, {"in window 40", "breaks off after"}},
    {"claims_too_many_bytes",
     5,
     broken,
     {"in window 40", "corrupted the shared memory", "bytes in a ring of 262144"},
     "shm"},
    {"claims_bytes_never_written",
     5,
     broken,
     {"in window 40", "corrupted the shared memory: no message begins with 0x"},
     "shm"},
    {"offers_no_memory",
     2,
     wrong,
     {"scene.toml:", "coupling.transport: found \"shm\"", "cannot have: it offers no shared memory"},
     "shm"},
    {"offers_memory_of_another",
     2,
     wrong,
     {"found \"shm\"", "it is that of another process", "\"auto\" allows"},
     "shm"},
    {"dies_after_hello", 4, failed, {"was killed by signal 9 (SIGKILL)"}},
    {"says_transposed", 5, broken, {"window 40", "1 x 2 numbers in 'increment'", "its interface has 2 x 1"}},
    {"says_far_window", 5, broken, {"answered 'window' = 4611686018427387904", "windows 40 to 40"}},
    {"says_far_row", 5, broken, {"in 'records' the history row of window 1e+300"}},
    {"says_absolute_unasked", 5, broken, {"2 rows in 'absolute' of window 40", "expected 0 rows: nobody asked for it"}},
    {"says_rates_unasked",
     5,
     broken,
     {"2 rows in 'velocity_m_s' of window 40", "expected 0 rows: nobody asked for it"}},
    {"says_records_unasked", 5, broken, {"1 rows in 'departures' of window 40", "nobody asked for it"}},
    {"says_contact_of_others",
     5,
     broken,
     {"reported a contact in window 40", "separated = true", "which it does not own"}},
    {"says_a_long_array", 5, broken, {"in window 40", "an array beyond the limit, allowed are 65536 values"}},
    {"describes_negative_step", 5, broken, {"described 'critical_time_step_s' = -1 s"}},
    {"describes_second_owner", 5, broken, {"described 'contact_owner' = true, and so did participant"}},
    {"describes_huge_mass", 5, broken, {"'interface_mass_kg' is 1e+300 kg, allowed are at most 1e+30"}},
    {"describes_transposed", 5, broken, {"'interface_mass_kg' is 1 x 2, expected 2 x 1"}},
    {"says_small_integers", 5, broken, {"in window 40", "a message of more than 131072 values"}},
    {"says_too_much", 5, broken, {"in window 40", "a message of 100000000 bytes, allowed are"}, "shm"},
    {"says_too_much",
     5,
     broken,
     {"has no connection any more in window 40", "sent a message of more than ", " bytes, which are allowed"},
     "zmq"},
    {"prints_for_ever", 4, failed, {"has printed", "bytes to its log", "allowed are 100000000"}},
    {"prints_escapes", 4, failed, {"ended with exit code 7 in window 40", "?]0;mine??[2J", "last words"}},
    {"loses_a_message", 5, broken, {"as message number", "one was lost or sent twice"}},
    {"diverges", 3, "unstable", {"failed in window 40", ": it diverges; likely cause: "}},
    {"finds_the_disk_full", 4, failed, {"failed in window 40", ": disk full"}},
    {"exits_silently", 4, failed, {"ended with exit code 7 in window 40"}},
    {"exits_badly_after_all", 4, failed, {"finished its work but ended with exit code 9"}},
    {"greets_in_another_version", 4, failed, {"version 99", "this program speaks version 7", "the same release"}},
    {"greets_with_nonsense", 4, failed, {"before it said hello"}},
    {"greets_too_late", 4, failed, {"the first message must be 'hello', not 'description'"}},
    {"has_another_role", 2, wrong, {"says it is implicit, the scene wants explicit"}},
    {"read_another_scene", 2, wrong, {"read another scene", "give both the same file"}},
};

std::vector<HabitOver> habits_over_each_transport() {
  std::vector<HabitOver> all;
  for (const auto& habit : habits) {
    for (const std::string transport : {"shm", "zmq"}) {
      if (!habit.transport || habit.transport == transport) all.emplace_back(habit, transport);
    }
  }
  return all;
}

class BadManners : public testing::TestWithParam<HabitOver> {};

TEST_P(BadManners, ends_the_run_and_names_the_participant) {
  const auto& [habit, transport] = GetParam();
  const TemporaryFolder folder;
  const std::string executable = "executable = \"" + program("fake_participant") + "\"";
  const std::string scene = with_key(bars(few_windows), "coupling", "transport", "\"" + transport + "\"");
  FaultRun run(folder, with_participants(scene, habit.name, executable));
  auto words = habit.words;
  words.push_back(std::string("participant '") + habit.name + "'");
  expect_failure(run, habit.code, habit.status, words);
  expect_recovery(run, folder);
}

INSTANTIATE_TEST_SUITE_P(Faults, BadManners, testing::ValuesIn(habits_over_each_transport()),
                         [](const auto& test) { return test.param.second + "_" + test.param.first.name; });

TEST(BadManners, what_was_asked_for_and_left_out_is_named) {
  const TemporaryFolder folder;
  const std::string scene = with_key(bars(few_windows), "coupling", "resynchronise_every", "40");
  FaultRun run(folder,
               with_participants(scene, "leaves_out_absolute", "executable = \"" + program("fake_participant") + "\""));
  expect_failure(run, 5, broken, {"answered window 40 with 0 x 1 numbers in 'absolute', its interface has 2 x 1"});
}

using NameOverTransport = std::pair<std::string, std::string>;

class NeverReads : public testing::TestWithParam<NameOverTransport> {};

/// One message that it is sent waits for it, and it is named when the time for an answer is over.
TEST_P(NeverReads, it_is_named_at_the_deadline_and_nobody_else_is_kept) {
  const auto& [name, transport] = GetParam();
  const TemporaryFolder folder;
  const std::string executable = "executable = \"" + program("fake_participant") + "\"";
  const std::string scene = with_key(bars(few_windows, 2.0), "coupling", "transport", "\"" + transport + "\"");
  FaultRun run(folder, with_participants(scene, name, executable));
  double peak = 0.0;
  wait_until([&] { return peak = std::max(peak, peak_memory(run.coupler().pid())), !run.coupler().running(); }, 20.0);
  EXPECT_GT(peak, 0.0);
  EXPECT_LT(peak, 500e6) << "the coupler took memory for what is not read";
  const std::string place = name == "never_reads" ? "during start-up" : "in window 41";
  expect_failure(run, 4, "participant_failed",
                 {"participant '" + name + "' has been silent for ", place, "coupling.timeout_s = 2 s"});
  expect_recovery(run, folder);
}

std::vector<NameOverTransport> never_reading() {
  std::vector<NameOverTransport> all;
  for (const std::string name : {"never_reads", "stops_reading"}) {
    for (const std::string transport : {"shm", "zmq", "tcp"}) all.emplace_back(name, transport);
  }
  return all;
}

INSTANTIATE_TEST_SUITE_P(Faults, NeverReads, testing::ValuesIn(never_reading()),
                         [](const auto& test) { return test.param.second + "_" + test.param.first; });

TEST(StrangersAmongTheRun, nonsense_of_a_stranger_does_not_end_it) {
  const TemporaryFolder folder;
  const std::string executable = "executable = \"" + program("fake_participant") + "\"";
  FaultRun run(folder, with_participants(bars(few_windows), "brings_a_flood", executable));
  EXPECT_EQ(run.coupler().wait(20.0), 0) << run.error_text();
  expect_recovery(run, folder);
}

}  // namespace
}  // namespace ricochet::test
