#include "common/participant/incremental_link.hpp"

#include <algorithm>
#include <cmath>

namespace ricochet::participant {

IncrementalLink::IncrementalLink(int nodes, int components) : nodes_(nodes), components_(components) {
  const auto size = static_cast<std::size_t>(nodes) * static_cast<std::size_t>(components);
  for (auto* values : {&input_, &accepted_input_, &output_, &accepted_output_}) values->assign(size, 0.0);
}

void IncrementalLink::set_input(const wire::Array& absolute) { accepted_input_ = input_ = absolute.data; }

void IncrementalLink::set_output(const std::vector<double>& absolute) { accepted_output_ = output_ = absolute; }

void IncrementalLink::receive(const wire::Array& increment, const wire::Array& absolute) {
  for (std::size_t i = 0; i < input_.size(); ++i) input_[i] = accepted_input_[i] + increment.data[i];
  if (absolute.rows == 0) return;
  largest_drift_ = std::max(largest_drift_, wire::relative_difference(input_, absolute.data));
  input_ = absolute.data;
}

void IncrementalLink::send(const std::vector<double>& output, bool with_absolute, wire::Array& increment,
                           wire::Array& absolute) {
  increment.resize(nodes_, components_);
  for (std::size_t i = 0; i < output.size(); ++i) {
    increment.data[i] = output[i] - accepted_output_[i];
    output_[i] = accepted_output_[i] + increment.data[i];
  }
  absolute.resize(with_absolute ? nodes_ : 0, components_);
  if (!with_absolute) return;
  absolute.data = output;
  output_ = output;
}

void IncrementalLink::accept() {
  accepted_input_.swap(input_);
  accepted_output_.swap(output_);
}

}  // namespace ricochet::participant
