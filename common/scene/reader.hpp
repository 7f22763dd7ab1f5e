#pragma once

#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/vocabulary.hpp"
#include "common/scene/schema.hpp"
#include "common/scene/toml_file.hpp"

namespace ricochet::scene {

/// Interval of allowed numbers, with the words an error uses for it.
struct Range {
  double low, high;
  bool low_included, high_included;

  [[nodiscard]] bool contains(double x) const;
  [[nodiscard]] std::string text() const;  ///< e.g. "a number > 0", "a number >= 0 and < 0.5"
};
[[nodiscard]] Range any_number();
[[nodiscard]] Range above(double low);
[[nodiscard]] Range at_least(double low);

/// One table of a scene file, or of a file with another schema, read strictly. Keys that its kind (see schema.hpp) does
/// not know are refused when it is opened; each getter checks type and range; every error is a ConfigError that shows
/// file, line, key, what was found, what is allowed, the nearest known name, and the underlined source. `lines`
/// collects the line of each key read.
class TableReader {
 public:
  struct Context {
    std::string file;
    std::map<std::string, int>& lines;
    const Schema* schema = &scene_schema();
  };

  /// `path` is the key of the table itself ("body.steel.mesh"), empty for the whole file.
  TableReader(const Toml& value, std::string kind, std::string path, Context context);

  [[nodiscard]] bool has(const std::string& key) const;
  [[nodiscard]] bool is_array(const std::string& key) const;
  [[nodiscard]] bool is_text(const std::string& key) const;
  /// From here on the table is called `path` in errors and in `lines` (a body once its name is known).
  void rename(const std::string& path);

  [[nodiscard]] double number(const std::string& key, const Range& range);
  [[nodiscard]] double number(const std::string& key, const Range& range, double otherwise);
  [[nodiscard]] int integer(const std::string& key, int low, int high);
  [[nodiscard]] int integer(const std::string& key, int low, int high, int otherwise);
  [[nodiscard]] bool boolean(const std::string& key, bool otherwise);
  [[nodiscard]] std::string text(const std::string& key);
  [[nodiscard]] std::string text(const std::string& key, const std::string& otherwise);
  /// Text of letters, digits, '_' and '-' only: it becomes part of file, column and endpoint names.
  [[nodiscard]] std::string name(const std::string& key);
  /// One of `allowed`.
  [[nodiscard]] std::string word(const std::string& key, const std::vector<std::string>& allowed);
  /// The value that belongs to the word found.
  template <typename T>
  [[nodiscard]] T choice(const std::string& key, const std::vector<std::pair<std::string, T>>& allowed, T otherwise);
  /// The value of an enum by one of its names (vocabulary.hpp).
  template <class E>
  [[nodiscard]] E named(const std::string& key) {
    return *find_named<E>(word(key, all_names<E>()));
  }
  /// Exactly `size` numbers; any number of them but none if `size` is 0.
  [[nodiscard]] std::vector<double> numbers(const std::string& key, const Range& range, std::size_t size);
  [[nodiscard]] std::vector<int> integers(const std::string& key, int low, int high, std::size_t size);
  [[nodiscard]] std::vector<std::string> texts(const std::string& key);
  /// Texts that are each one of `allowed`, no two the same.
  [[nodiscard]] std::vector<std::string> words(const std::string& key, const std::vector<std::string>& allowed);
  [[nodiscard]] TableReader table(const std::string& key, const std::string& kind);
  /// Array of tables ([[key]] or key = [{...}]); empty if the key is missing.
  [[nodiscard]] std::vector<TableReader> tables(const std::string& key, const std::string& kind);
  /// One table ([key]) or an array of them; empty if the key is missing.
  [[nodiscard]] std::vector<TableReader> table_or_tables(const std::string& key, const std::string& kind);
  /// Tables of one kind by names of the user's ([key.NAME]); empty if the key is missing.
  [[nodiscard]] std::map<std::string, TableReader> tables_by_name(const std::string& key, const std::string& kind);
  /// A table whose keys must be among `allowed` (bodies): numbers in `range`, or lists of texts.
  [[nodiscard]] std::map<std::string, double> numbers_by_name(const std::string& key, const Range& range,
                                                              const std::vector<std::string>& allowed);
  [[nodiscard]] std::map<std::string, std::vector<std::string>> texts_by_name(const std::string& key,
                                                                              const std::vector<std::string>& allowed);

  /// The value of a key as it stands, for tables whose keys are not known beforehand; null if it is not there.
  [[nodiscard]] const Toml* open(const std::string& key) { return take(key); }

  /// Refuses `key`, if it is there, unless `condition`: "allowed: only with `needs`".
  void only_if(bool condition, const std::string& key, const std::string& needs);
  /// Every key of the table must have been asked for: a loader that forgets one is a bug (std::logic_error).
  void finish() const;

  [[nodiscard]] const std::string& path() const { return path_; }
  /// ConfigError about a key that is there.
  [[noreturn]] void refuse(const std::string& key, const std::string& found, const std::string& allowed) const;
  /// The same for a value below one that was opened: `key` is its whole name.
  [[noreturn]] void fail(const Toml& at, const std::string& key, const std::string& found,
                         const std::string& allowed) const;
  /// ConfigError about a key that is not there, or the table as a whole.
  [[noreturn]] void missing(const std::string& key, const std::string& allowed) const;

 private:
  const Toml* take(const std::string& key);
  const Toml& need(const std::string& key, const std::string& allowed);
  [[nodiscard]] std::string full(const std::string& key) const;
  [[nodiscard]] double to_number(const Toml& value, const std::string& key, const Range& range) const;
  [[nodiscard]] int to_integer(const Toml& value, const std::string& key, int low, int high) const;
  [[nodiscard]] const std::string& to_text(const Toml& value, const std::string& key) const;
  [[nodiscard]] const std::vector<Toml>& to_array(const Toml& value, const std::string& key, const std::string& of,
                                                  std::size_t size) const;
  [[nodiscard]] const Toml& body_table(const std::string& key, const std::vector<std::string>& allowed);

  const Toml* value_;
  std::string kind_, path_;
  Context context_;
  std::set<std::string> taken_;
};

template <typename T>
T TableReader::choice(const std::string& key, const std::vector<std::pair<std::string, T>>& allowed, T otherwise) {
  std::vector<std::string> names;
  for (const auto& entry : allowed) names.push_back(entry.first);
  if (!has(key)) return otherwise;
  const std::string found = word(key, names);
  for (const auto& [text, value] : allowed)
    if (text == found) return value;
  return otherwise;
}

/// How errors show a value: "an array of 2", "\"text\"", "1.5".
[[nodiscard]] std::string value_text(const Toml& value);

/// `"a", "b" or "c"`.
[[nodiscard]] std::string one_of(const std::vector<std::string>& allowed);

}  // namespace ricochet::scene
