#include <fmt/format.h>

#include <algorithm>

#include "coupler/command/method_choice.hpp"
#include "coupler/results/csv_cell.hpp"

/// A choice as tables and lines.
namespace ricochet::coupler {

std::string to_csv(const MethodChoice& choice, const AskedErrors& asked) {
  std::string text = "protocol,step_s,elements_times,predicted_s";
  for (const auto& [quantity, error] : asked) text += fmt::format(",expected_error/{0},order/{0}", quantity);
  text += ",refused\n";
  for (const auto& p : choice.proposals) {
    text += fmt::format("{},{:.6g},{:g},{}", p.protocol, p.step_s, p.elements_times,
                        p.predicted_s > 0.0 ? fmt::format("{:.6g}", p.predicted_s) : "");
    for (const auto& [quantity, error] : asked) {
      const auto bar = p.bars.find(quantity);
      if (bar == p.bars.end()) {
        text += ",,";
      } else {
        text += fmt::format(",{:.6g},{}", bar->second.relative,
                            bar->second.order ? fmt::format("{:.6g}", *bar->second.order) : "");
      }
    }
    text += "," + csv_cell(p.refused) + "\n";
  }
  return text;
}

std::string to_table(const MethodChoice& choice, const AskedErrors& asked) {
  const bool one_mesh = std::all_of(choice.proposals.begin(), choice.proposals.end(),
                                    [](const Proposal& p) { return p.elements_times == 1.0; });
  const auto mesh = [one_mesh](const std::string& text) { return one_mesh ? "" : fmt::format(" {:>8}", text); };
  std::string text = fmt::format("{:<20} {:>11}{} {:>14}", "protocol", "step [s]", mesh("elements"), "predicted [s]");
  for (const auto& [quantity, error] : asked)
    text += fmt::format("  {}", asked.size() == 1 ? " expected error" : "error of " + quantity);
  text += "\n";
  for (std::size_t i = 0; i < choice.proposals.size(); ++i) {
    const auto& p = choice.proposals[i];
    if (p.bars.empty() && (p.refused.empty() || p.predicted_s == 0.0)) continue;
    text += fmt::format("{:<20} {:>11.4g}{} {:>14.3g}", p.protocol, p.step_s,
                        mesh(fmt::format("x {:g}", p.elements_times)), p.predicted_s);
    for (const auto& [quantity, bar] : p.bars) {
      const std::size_t width = asked.size() == 1 ? 15 : quantity.size() + 9;
      text += fmt::format("  {:>{}.2g} %", 100.0 * bar.relative, width - 2);
    }
    if (p.bars.empty()) text += "  " + p.refused;
    text += i == choice.best ? "  best\n" : i == choice.next ? "  next\n" : "\n";
  }
  return text;
}

std::string to_text(const AskedErrors& asked) {
  std::string text;
  for (const auto& [quantity, error] : asked)
    text += fmt::format("{}{} within {:g} %", text.empty() ? "" : ", ", quantity, 100.0 * error);
  return text;
}

}  // namespace ricochet::coupler
