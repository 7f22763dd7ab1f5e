#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace ricochet {

class Archive;

/// A struct that names what it keeps: `void archive(Archive& a) { a(this, that); }`.
template <class T>
concept Archived = requires(T& value, Archive& archive) {
  value.archive(archive);
};

/// Numbers in a row in memory: std::vector<double> and what Eigen has for a vector.
template <class T>
concept Numbers = requires(T& values) {
  { values.data() } -> std::same_as<double*>;
  values.size();
  values.resize(values.size());
};

/// Bytes of a state that has to survive, for checkpoints: the same list of members writes and reads. Numbers are kept
/// bit for bit, as they lie in memory (little-endian); of variable length is whatever says its size first.
///
///   Archive out;            Archive in(bytes);
///   out(state);             in(state);
///   bytes = out.take();     in.end();
///
/// Nothing is trusted in reading: sizes are bounded by the bytes that are left, and where something is impossible it
/// throws ConfigError. Reading keeps what the archive does not name: an object of the same scene goes on from there.
/// A range of one size in all states of a scene is read by `same_size`; one that is then indexed by others of that size
/// can be.
class Archive {
 public:
  Archive() = default;  ///< writes
  /// Reads `bytes`, which must outlive it; `what` they are, for error texts.
  Archive(std::string_view bytes, std::string what) : reading_(true), unread_(bytes), what_(std::move(what)) {}

  [[nodiscard]] bool reading() const { return reading_; }
  /// All that was written.
  [[nodiscard]] std::string take() { return std::move(written_); }
  /// After reading: refuses bytes that are left.
  void end() const;

  template <class... T>
  void operator()(T&... values) {
    (item(values), ...);
  }
  /// In reading, lists and what may be missing have to have the size that they have now, and all that they hold, too.
  template <class... T>
  void same_size(T&... values) {
    with_sizes(true, values...);
  }
  /// Within that, of any size.
  template <class... T>
  void any_size(T&... values) {
    with_sizes(false, values...);
  }
  /// Raised by `archive` of a struct that finds what it read to be impossible.
  [[noreturn]] void refuse(const std::string& why) const;

 private:
  template <class... T>
  void with_sizes(bool same, T&... values) {
    const bool before = std::exchange(same_size_, same);
    (item(values), ...);
    same_size_ = before;
  }
  void raw(void* data, std::size_t bytes);
  /// The number of items, each of which takes at least so many bytes.
  std::size_t size(std::size_t present, std::size_t least_bytes);

  template <class T>
  requires(std::is_arithmetic_v<T> && !std::same_as<T, bool>) void item(T& value) { raw(&value, sizeof value); }
  void item(bool& value);
  void item(std::string& text);
  void item(std::vector<bool>& values);
  template <class T>
  requires std::is_enum_v<T>
  void item(T& value) {
    auto number = static_cast<std::int64_t>(value);
    raw(&number, sizeof number);
    value = static_cast<T>(number);
  }
  template <Numbers T>
  void item(T& values) {
    const auto count = size(static_cast<std::size_t>(values.size()), sizeof(double));
    if constexpr (of_fixed_size<T>()) {
      if (static_cast<std::size_t>(values.size()) != count) refuse("numbers of another dimension");
    } else {
      if (reading_) values.resize(static_cast<decltype(values.size())>(count));
    }
    raw(values.data(), count * sizeof(double));
  }
  template <Archived T>
  void item(T& value) {
    value.archive(*this);
  }
  template <class T>
  requires(!Numbers<std::vector<T>> && !std::same_as<T, bool>) void item(std::vector<T>& values) { each_of(values); }
  template <class T>
  void item(std::deque<T>& values) {
    each_of(values);
  }
  template <class T, std::size_t n>
  void item(std::array<T, n>& values) {
    for (auto& value : values) item(value);
  }
  template <class T>
  void item(std::optional<T>& value) {
    bool there = value.has_value();
    item(there);
    if (reading_ && same_size_ && there != value.has_value()) refuse("it is of another scene");
    if (reading_ && there != value.has_value()) {
      if (there) {
        value.emplace();
      } else {
        value.reset();
      }
    }
    if (there) item(*value);
  }
  /// Which of the kinds it is does not change.
  template <class... T>
  void item(std::variant<T...>& value) {
    std::uint64_t index = value.index();
    item(index);
    if (index != value.index()) refuse("another kind of state");
    std::visit([this](auto& held) { item(held); }, value);
  }
  /// Eigen's vectors and matrices with the dimension in the type.
  template <class T>
  static constexpr bool of_fixed_size() {
    if constexpr (requires { T::SizeAtCompileTime; }) {
      return T::SizeAtCompileTime >= 0;
    } else {
      return false;
    }
  }
  template <class T>
  void each_of(T& values) {
    const auto count = size(values.size(), 1);
    if (reading_) values.resize(count);
    for (auto& value : values) item(value);
  }

  bool reading_ = false, same_size_ = false;
  std::string written_;
  std::string_view unread_;
  std::string what_;
};

}  // namespace ricochet
