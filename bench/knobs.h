// Knobs of a bench: every combination of the values given for each is run.
#pragma once

#include <algorithm>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace kinora::bench {

/// One value of each knob.
using Setting = std::map<std::string, double>;
/// All values of each knob.
using Knobs = std::map<std::string, std::vector<double>>;

/// Takes `name=value,value,…`; false if it is none of a knob. Words stand for their places in `words`.
inline bool set_knob(const std::string& argument, Knobs& knobs, const std::vector<std::string>& words = {}) {
  const std::size_t equals = argument.find('=');
  if (equals == std::string::npos || !knobs.contains(argument.substr(0, equals))) return false;
  std::vector<double>& values = knobs[argument.substr(0, equals)];
  values.clear();
  std::istringstream list(argument.substr(equals + 1));
  for (std::string value; std::getline(list, value, ',');) {
    const auto word = std::find(words.begin(), words.end(), value);
    values.push_back(word != words.end() ? static_cast<double>(word - words.begin()) : std::stod(value));
  }
  return !values.empty();
}

namespace detail {
template <class Run> void run_all(const Knobs& knobs, Knobs::const_iterator next, Setting& setting, const Run& run) {
  if (next == knobs.end()) return run(setting);
  for (const double value : next->second) {
    setting[next->first] = value;
    run_all(knobs, std::next(next), setting, run);
  }
}
} // namespace detail

/// Calls run(setting) for every combination.
template <class Run> void run_all(const Knobs& knobs, const Run& run) {
  Setting setting;
  detail::run_all(knobs, knobs.begin(), setting, run);
}

} // namespace kinora::bench
