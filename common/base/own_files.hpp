#pragma once

#include <map>
#include <string>
#include <vector>

namespace ricochet {

/// The files that this program wrote into a folder, known by a list that it keeps there (`.ricochet-files`). A file
/// that is not on the list, or was changed since it was written, belongs to somebody else: it is never removed nor
/// written over.
class OwnFiles {
 public:
  static constexpr const char* list_name = ".ricochet-files";

  /// Reads the list, if there is one. Throws ConfigError if it is not one of ours.
  explicit OwnFiles(std::string folder);
  OwnFiles(const OwnFiles&) = delete;
  OwnFiles& operator=(const OwnFiles&) = delete;
  /// Notes how each claimed file looks now, by which a later change of it is known, and removes halves of files.
  ~OwnFiles();

  /// A file that this command reads, wherever it lies: from now on it is neither removed nor claimed, even if ours.
  void keep(const std::vector<std::string>& paths) { kept_ = paths; }
  /// A file that was changed since it was written, or copied, is somebody else's, unless a run goes on from it.
  enum class Changed { refused, accepted };
  /// Makes names below the folder ours, on disk before it returns; '#' stands for one or more digits. With each name
  /// goes that of its half, ".part" appended. Throws ConfigError that names the first file which is there already and
  /// is not ours, or is kept; then nothing is claimed.
  void claim(const std::vector<std::string>& names, Changed changed = Changed::refused);
  /// Removes what is ours, and folders that become empty by that.
  void remove_all();
  /// Removes halves of what is claimed: of a process that was killed while it wrote.
  void remove_halves();

 private:
  enum class Owner { nobody, us, somebody_else };
  struct Stamp {
    long long size = -1, time_ns = -1;  ///< -1: it was claimed, but nobody noted how it looked at the end
    bool operator==(const Stamp&) const = default;
  };

  [[nodiscard]] Owner owner_of(const std::string& name, Changed changed = Changed::refused) const;
  [[nodiscard]] std::vector<std::string> present(const std::string& pattern) const;
  [[nodiscard]] bool is_kept(const std::string& name) const;
  [[nodiscard]] Stamp stamp_of(const std::string& name) const;
  void read();
  void write() const;
  void seal();

  std::string folder_;
  std::map<std::string, Stamp> listed_;  ///< names and patterns
  std::vector<std::string> claimed_;     ///< by this object
  std::vector<std::string> kept_;        ///< paths
};

}  // namespace ricochet
