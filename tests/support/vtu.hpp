#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/support/process.hpp"

/// Reads one array out of a VTU file with inline base64 (UInt64 header): enough to check what a run wrote.
namespace ricochet::test {

inline std::string decode_base64(const std::string& text) {
  const std::string alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  std::uint32_t bits = 0;
  int count = 0;
  for (const char c : text) {
    const auto value = alphabet.find(c);
    if (value == std::string::npos) continue;
    bits = (bits << 6) | static_cast<std::uint32_t>(value);
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes.push_back(static_cast<char>((bits >> count) & 0xFF));
  }
  return bytes;
}

template <class Number = double>
std::vector<Number> vtu_array(const std::string& path, const std::string& name) {
  const std::string text = file_text(path);
  const auto tag = text.find("Name=\"" + name + "\"");
  if (tag == std::string::npos) throw std::runtime_error(path + " has no array " + name);
  const auto begin = text.find('>', tag) + 1;
  const std::string bytes = decode_base64(text.substr(begin, text.find('<', begin) - begin));
  std::vector<Number> values((bytes.size() - sizeof(std::uint64_t)) / sizeof(Number));
  std::memcpy(values.data(), bytes.data() + sizeof(std::uint64_t), values.size() * sizeof(Number));
  return values;
}

/// One component of the tensor `name` ("stress" or "strain") of every cell: "xx", "yy", "zz", "xy", "yz" or "xz".
inline std::vector<double> vtu_component(const std::string& path, const std::string& name,
                                         const std::string& component) {
  const std::vector<std::string> names{"xx", "yy", "zz", "xy", "yz", "xz"};
  const auto at = static_cast<std::size_t>(std::find(names.begin(), names.end(), component) - names.begin());
  const auto all = vtu_array(path, name);
  std::vector<double> values;
  for (std::size_t cell = at; cell < all.size(); cell += names.size()) values.push_back(all[cell]);
  return values;
}

}  // namespace ricochet::test
