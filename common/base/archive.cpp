#include "common/base/archive.hpp"

#include <fmt/format.h>

#include <bit>
#include <cstring>

#include "common/base/error.hpp"

namespace ricochet {

static_assert(std::endian::native == std::endian::little, "numbers are kept as they lie in memory");

void Archive::refuse(const std::string& why) const { throw ConfigError(fmt::format("{}: {}", what_, why)); }

void Archive::end() const {
  if (!unread_.empty()) refuse(fmt::format("{} bytes too many", unread_.size()));
}

void Archive::raw(void* data, std::size_t bytes) {
  if (bytes == 0) return;
  if (!reading_) {
    written_.append(static_cast<const char*>(data), bytes);
    return;
  }
  if (bytes > unread_.size()) refuse(fmt::format("it breaks off: {} bytes are missing", bytes - unread_.size()));
  std::memcpy(data, unread_.data(), bytes);
  unread_.remove_prefix(bytes);
}

std::size_t Archive::size(std::size_t present, std::size_t least_bytes) {
  std::uint64_t count = present;
  raw(&count, sizeof count);
  if (reading_ && count > unread_.size() / least_bytes) refuse(fmt::format("it breaks off in {} numbers", count));
  if (reading_ && same_size_ && count != present)
    refuse(fmt::format("it is of another scene: a list of {}, expected {}", count, present));
  return count;
}

void Archive::item(bool& value) {
  char byte = value ? 1 : 0;
  raw(&byte, 1);
  if (byte != 0 && byte != 1) refuse("neither true nor false");
  value = byte == 1;
}

void Archive::item(std::string& text) {
  const auto count = size(text.size(), 1);
  if (reading_) text.resize(count);
  raw(text.data(), count);
}

void Archive::item(std::vector<bool>& values) {
  const auto count = size(values.size(), 1);
  if (reading_) values.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    bool value = values[i];
    item(value);
    values[i] = value;
  }
}

}  // namespace ricochet
