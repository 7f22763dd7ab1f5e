#include "common/base/error.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <new>
#include <system_error>

namespace ricochet {

void throw_errno(int error, const std::string& what) {
  const std::string text = fmt::format("{}: {} (errno {})", what, std::strerror(error), error);
  switch (error) {
    case ENOSPC:
    case EDQUOT:
    case EFBIG:
    case EIO:
    case EMFILE:
    case ENFILE:
    case ENOMEM:
    case EAGAIN: throw MachineError(text);
    default: throw ConfigError(text);
  }
}

std::string text_of(const std::exception& error) {
  if (dynamic_cast<const std::bad_alloc*>(&error))
    return "out of memory: the machine, or the limit of this process (ulimit -v), has no more";
  return error.what();
}

int exit_code_of_exception(const std::exception& error) {
  if (const auto* known = dynamic_cast<const Error*>(&error)) return static_cast<int>(known->code());
  const bool machine = dynamic_cast<const std::bad_alloc*>(&error) || dynamic_cast<const std::system_error*>(&error);
  return machine ? static_cast<int>(ExitCode::machine) : 1;
}

}  // namespace ricochet
