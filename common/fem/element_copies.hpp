#pragma once

#include <string>
#include <unordered_map>

#include "common/fem/element.hpp"

namespace ricochet::fem {

/// Keeps what an element's matrix_places and material alone determine, once for all copies of an element. `Make` is
/// called with the geometry of the first of them. From some thousand different elements only the first are kept: such a
/// mesh is not made of copies, and what is kept of every element would take more than K.
template <class Value>
class ElementCopies {
 public:
  explicit ElementCopies(Model model) : model_(model) {}

  template <class Make>
  const Value& of(const ElementGeometry& geometry, const Make& make, int material = -1) {
    const ElementCoordinates x = matrix_places(model_, geometry);
    key_.assign(1, static_cast<char>(geometry.kind));
    key_.append(reinterpret_cast<const char*>(&material), sizeof(material));
    key_.append(reinterpret_cast<const char*>(x.data()), static_cast<std::size_t>(x.size()) * sizeof(double));
    const auto found = known_.find(key_);
    if (found != known_.end()) return found->second;
    if (known_.size() < most_kept) return known_.emplace(key_, make(geometry)).first->second;
    return other_ = make(geometry);
  }

 private:
  static constexpr std::size_t most_kept = 4096;
  Model model_;
  std::unordered_map<std::string, Value> known_;
  Value other_{};
  std::string key_;
};

}  // namespace ricochet::fem
