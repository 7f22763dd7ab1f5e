#include <gmock/gmock.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <iterator>
#include <new>
#include <system_error>

#include "common/base/error.hpp"
#include "common/base/process.hpp"
#include "common/base/write_file.hpp"

namespace ricochet {
namespace {

using testing::AllOf;
using testing::HasSubstr;

std::string text_in(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(Printable, ControlCharactersCannotReachATerminal) {
  EXPECT_EQ(printable("\x1b]0;title\x07\r\x7f"), "?]0;title???");
  EXPECT_EQ(printable("a\xc2\x9b"
                      "31m\xc3\xa9"),
            "a?31m\xc3\xa9")
      << "C1 in UTF-8 goes, letters stay";
  EXPECT_EQ(printable("two\n\tlines"), "two\n\tlines");
}

/// With which "txt.exe" could be shown for what is "exe.txt".
TEST(Printable, MarksOfDirectionCannotReachATerminal) {
  for (const char* mark : {"\u061c", "\u200e", "\u200f", "\u2028", "\u2029", "\u202a", "\u202b", "\u202c", "\u202d",
                           "\u202e", "\u2066", "\u2067", "\u2068", "\u2069"})
    EXPECT_EQ(printable(std::string("a") + mark + "b"), "a?b");
  for (const char* letter : {"\u061b", "\u2010", "\u202f", "\u206a", "\u05d0", "\u20ac"})
    EXPECT_EQ(printable(letter), letter);
  EXPECT_EQ(printable("\xe2\x80"), "\xe2\x80") << "half of one";
}

TEST(Errors, OfTheMachineHaveTheirOwnExitCodeAndTheCause) {
  for (const int error : {ENOSPC, EDQUOT, EFBIG, EIO, EMFILE, ENFILE, ENOMEM}) {
    try {
      throw_errno(error, "cannot write x");
    } catch (const std::exception& thrown) {
      EXPECT_EQ(exit_code_of_exception(thrown), 7);
      EXPECT_THAT(thrown.what(),
                  AllOf(HasSubstr("cannot write x: "), HasSubstr("(errno " + std::to_string(error) + ")")));
    }
  }
  EXPECT_THROW(throw_errno(EACCES, "x"), ConfigError);
  EXPECT_EQ(exit_code_of_exception(std::bad_alloc()), 7);
  EXPECT_EQ(exit_code_of_exception(std::system_error(std::make_error_code(std::errc::too_many_files_open))), 7);
  EXPECT_EQ(exit_code_of_exception(std::runtime_error("x")), 1);
  EXPECT_THAT(text_of(std::bad_alloc()), HasSubstr("out of memory"));
}

TEST(WriteFile, NothingStaysOfAFailureAndAForeignHalfIsNotTouched) {
  const std::string path = testing::TempDir() + "write_" + std::to_string(getpid());
  rlimit limit{};
  getrlimit(RLIMIT_FSIZE, &limit);
  const rlimit small{1000, limit.rlim_max};
  prepare_process();
  write_atomically(path, "old");
  setrlimit(RLIMIT_FSIZE, &small);
  EXPECT_THROW(write_atomically(path, std::string(5000, 'x')), MachineError);
  setrlimit(RLIMIT_FSIZE, &limit);
  EXPECT_EQ(text_in(path), "old");
  EXPECT_NE(access((path + ".part").c_str(), F_OK), 0);
  std::ofstream(path + ".part") << "somebody's";
  EXPECT_THROW(write_atomically(path, "new"), ConfigError);
  EXPECT_EQ(text_in(path + ".part"), "somebody's");
  unlink((path + ".part").c_str());
  unlink(path.c_str());
}

TEST(WriteFile, WithinWhatAFileTakesNeedsNoRoom) {
  const std::string path = testing::TempDir() + "within_" + std::to_string(getpid());
  write_atomically(path, "0123456789");
  EXPECT_TRUE(write_within(path, "abc"));
  EXPECT_EQ(text_in(path), "abc       ");
  EXPECT_FALSE(write_within(path, "longer than that"));
  EXPECT_EQ(text_in(path), "abc       ");
  unlink(path.c_str());
  EXPECT_FALSE(write_within(path, "abc"));
}

}  // namespace
}  // namespace ricochet
