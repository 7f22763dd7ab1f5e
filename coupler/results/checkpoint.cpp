#include "coupler/results/checkpoint.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "common/base/error.hpp"
#include "common/base/read_file.hpp"
#include "common/base/sha256.hpp"
#include "common/base/user_key.hpp"
#include "common/base/write_file.hpp"
#include "coupler/results/field_digests.hpp"

namespace ricochet::coupler {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int format_version = 2;

/// Everything written to the file system of `folder` so far is on its disk when this returns.
void sync(const std::string& folder) {
  const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) throw_errno(errno, "cannot open " + folder);
  const int error = syncfs(descriptor) == 0 ? 0 : errno;
  close(descriptor);
  if (error != 0) throw_errno(error, "cannot write " + folder);
}

/// The number that a file's name begins with; nothing if it does not.
std::optional<std::int64_t> window_of(const std::string& file) {
  std::int64_t window = 0;
  const auto [end, error] = std::from_chars(file.data(), file.data() + file.size(), window);
  if (error != std::errc() || end == file.data() + file.size() || *end != '.') return std::nullopt;
  return window;
}

std::vector<std::string> files_in(const std::string& folder) {
  std::vector<std::string> files;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder, none)) files.push_back(entry.path().filename().string());
  return files;
}

Json told(const std::string& participant, const std::string& bytes) {
  Json entry = Json::object();
  if (!participant.empty()) entry["participant"] = participant;
  entry["bytes"] = bytes.size();
  entry["sha256"] = sha256_hex(bytes);
  return entry;
}

Json told(const Beginning& beginning) { return {{"bytes", beginning.bytes}, {"sha256", beginning.sha256}}; }

/// The digest of a manifest covers all that it says, but that and its signature.
std::string digest_of(Json manifest) {
  manifest.erase("sha256");
  manifest.erase("signature");
  return sha256_hex(manifest.dump(1));
}

/// Empty where this user has no key.
std::string signature_of(const std::string& digest) {
  const auto key = user_key();
  return key.empty() ? "" : hmac_sha256_hex(key, digest);
}

std::string whole(const std::string& path, std::int64_t size, const std::string& sha256) {
  auto bytes = read_file(path);
  if (static_cast<std::int64_t>(bytes.size()) != size || sha256_hex(bytes) != sha256)
    throw ConfigError(
        fmt::format("{} is not what was written: it has {} bytes and another SHA-256", path, bytes.size()));
  return bytes;
}

}  // namespace

std::vector<std::string> CheckpointFolder::names(const std::vector<std::string>& participants) {
  std::vector<std::string> names = {"checkpoint/#.json", "checkpoint/#.state", "checkpoint/request",
                                    FieldDigests::list_name};
  for (const auto& participant : participants) names.push_back("checkpoint/#." + participant + ".state");
  return names;
}

std::string CheckpointFolder::manifest(std::int64_t window) const { return fmt::format("{}/{}.json", path_, window); }

std::string CheckpointFolder::part(std::int64_t window, const std::string& participant) const {
  return participant.empty() ? fmt::format("{}/{}.state", path_, window)
                             : fmt::format("{}/{}.{}.state", path_, window, participant);
}

void CheckpointFolder::write(const Checkpoint& checkpoint) const {
  const auto window = checkpoint.window;
  const Computer computer = this_computer();
  Json json = {{"format", format_version},
               {"ricochet", RICOCHET_VERSION},
               {"scene", checkpoint.scene_path},
               {"scene_sha256", checkpoint.scene_sha256},
               {"protocol", checkpoint.protocol},
               {"window", window},
               {"time_s", checkpoint.time_s},
               {"history", told(checkpoint.history)},
               {"probes", told(checkpoint.probes)},
               {"fields", told(checkpoint.fields)},
               {"wall_s", checkpoint.wall_s},
               {"cpu_s", checkpoint.cpu_s},
               {"stepping_s", checkpoint.stepping_s},
               {"processor", computer.processor},
               {"blas", computer.blas},
               {"coupler", told("", checkpoint.coupler)},
               {"parts", Json::array()}};
  std::error_code error;
  fs::create_directories(path_, error);
  if (error) throw_errno(error.value(), "cannot create " + path_);
  remove(window);
  try {
    write_atomically(part(window, ""), checkpoint.coupler);
    for (const auto& one : checkpoint.parts) {
      json["parts"].push_back(told(one.participant, one.bytes));
      write_atomically(part(window, one.participant), one.bytes);
    }
    json["sha256"] = digest_of(json);
    json["signature"] = signature_of(json["sha256"]);
    sync(path_);
    write_atomically(manifest(window), json.dump(1) + "\n");
    sync(path_);
  } catch (...) {
    remove(window);
    throw;
  }
  const auto present = windows();
  const auto older = static_cast<std::ptrdiff_t>(present.size()) - kept;
  for (std::ptrdiff_t i = 0; i < older; ++i) remove(present[static_cast<std::size_t>(i)]);
}

std::vector<std::int64_t> CheckpointFolder::windows() const {
  std::vector<std::int64_t> found;
  for (const auto& file : files_in(path_)) {
    const auto window = window_of(file);
    if (window && file == fmt::format("{}.json", *window)) found.push_back(*window);
  }
  std::sort(found.begin(), found.end());
  return found;
}

/// The manifest first: from then on there is no cut.
void CheckpointFolder::remove(std::int64_t window) const {
  std::error_code ignored;
  fs::remove(manifest(window), ignored);
  for (const auto& file : files_in(path_)) {
    if (window_of(file) == window) fs::remove(path_ + "/" + file, ignored);
  }
}

void CheckpointFolder::forget_after(std::int64_t window) const {
  const auto present = windows();
  for (const auto& file : files_in(path_)) {
    const auto other = window_of(file);
    if (!other) continue;
    if (*other > window || !std::binary_search(present.begin(), present.end(), *other)) remove(*other);
  }
}

/// A manifest of another version is not read further; its own digest is looked at last, so that all that is wrong with
/// it otherwise has a name.
Checkpoint CheckpointFolder::read(std::int64_t window) const {
  const auto path = manifest(window);
  const auto count = [&path](const Json& table, const char* key) {  // `get` would take -1, 1.5 and 1e22 for one
    const auto& value = table.at(key);
    if (!value.is_number_unsigned() || value.get<std::uint64_t>() > std::numeric_limits<std::int64_t>::max())
      throw ConfigError(fmt::format("{} says {} = {}, which is not a count", path, key, value.dump()));
    return value.get<std::int64_t>();
  };
  const auto bytes_of = [&](const std::string& participant, const Json& entry) {
    return whole(part(window, participant), count(entry, "bytes"), entry.at("sha256").get<std::string>());
  };
  const auto beginning = [&](const Json& entry) {
    return Beginning{count(entry, "bytes"), entry.at("sha256").get<std::string>()};
  };
  try {
    const auto json = Json::parse(read_file(path));
    const auto format = count(json, "format");
    const auto version = json.at("ricochet").get<std::string>();
    if (format != format_version || version != RICOCHET_VERSION) {
      throw ConfigError(
          fmt::format("{} was written by ricochet {} (format {}), this is {} (format {}): resume with the version that "
                      "began",
                      path, version, format, RICOCHET_VERSION, format_version));
    }
    Checkpoint checkpoint{json.at("scene").get<std::string>(),
                          json.at("scene_sha256").get<std::string>(),
                          json.at("protocol").get<std::string>(),
                          count(json, "window"),
                          json.at("time_s").get<double>(),
                          beginning(json.at("history")),
                          beginning(json.at("probes")),
                          beginning(json.at("fields")),
                          json.at("wall_s").get<double>(),
                          json.at("cpu_s").get<double>(),
                          json.at("stepping_s").get<double>(),
                          bytes_of("", json.at("coupler")),
                          {}};
    for (const auto& entry : json.at("parts")) {
      const auto participant = entry.at("participant").get<std::string>();
      checkpoint.parts.push_back({participant, bytes_of(participant, entry)});
    }
    checkpoint.computer = {json.value("processor", ""), json.value("blas", "")};
    const auto digest = digest_of(json);
    if (json.at("sha256").get<std::string>() != digest || checkpoint.window != window)
      throw ConfigError(fmt::format("{} is not what was written: it has another SHA-256 than it says", path));
    const auto signature = signature_of(digest);
    checkpoint.by_this_user = !signature.empty() && json.at("signature").get<std::string>() == signature;
    return checkpoint;
  } catch (const nlohmann::json::exception& error) {
    throw ConfigError(fmt::format("{} is not a manifest of a checkpoint: {}", path, error.what()));
  }
}

std::optional<Checkpoint> CheckpointFolder::last(std::vector<std::string>& damaged) const {
  const auto results = fs::path(path_).parent_path().string();
  auto present = windows();
  for (; !present.empty(); present.pop_back()) {
    try {
      auto found = read(present.back());
      if (found.history.bytes > 0) static_cast<void>(require_beginning(results + "/history.csv", found.history));
      if (found.probes.bytes > 0) static_cast<void>(require_beginning(results + "/probes.csv", found.probes));
      FieldDigests::require(results, found.fields);
      return found;
    } catch (const ConfigError& error) {
      damaged.emplace_back(error.what());
    }
  }
  return std::nullopt;
}

}  // namespace ricochet::coupler
