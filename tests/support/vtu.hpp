#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/support/process.hpp"
#include "tests/support/same_results.hpp"

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

/// The files of a participant at a window, in the order of its bodies.
inline std::vector<std::string> field_files(const std::string& results, const std::string& participant, int window) {
  std::vector<std::pair<int, std::string>> found;
  for (const auto& path : fields_of(results, participant, window))
    found.emplace_back(vtu_array<std::int32_t>(path, "body").at(0), path);
  std::sort(found.begin(), found.end());
  std::vector<std::string> paths;
  for (const auto& [body, path] : found) paths.push_back(path);
  return paths;
}

/// The same of several bodies, one after the other.
template <class Number = double>
std::vector<Number> vtu_array(const std::vector<std::string>& paths, const std::string& name) {
  if (paths.empty()) throw std::runtime_error("no file with an array " + name);
  std::vector<Number> all;
  for (const auto& path : paths) {
    const auto of = vtu_array<Number>(path, name);
    all.insert(all.end(), of.begin(), of.end());
  }
  return all;
}

/// One component of the tensor `name` ("stress" or "strain") of every cell: "xx", "yy", "zz", "xy", "yz" or "xz".
template <class Files>
std::vector<double> vtu_component(const Files& files, const std::string& name, const std::string& component) {
  const std::vector<std::string> names{"xx", "yy", "zz", "xy", "yz", "xz"};
  const auto at = static_cast<std::size_t>(std::find(names.begin(), names.end(), component) - names.begin());
  const auto all = vtu_array(files, name);
  std::vector<double> values;
  for (std::size_t cell = at; cell < all.size(); cell += names.size()) values.push_back(all[cell]);
  return values;
}

}  // namespace ricochet::test
