#pragma once

#include <cstdint>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace flipflow {

// Arrays by name: all that decides, to the last bit, how a run goes on.
struct SavedState {
  std::map<std::string, std::vector<double>> reals;
  std::map<std::string, std::vector<std::int64_t>> wholes;

  const std::vector<double> &real(const std::string &name) const { return find(reals, name); }
  const std::vector<std::int64_t> &whole(const std::string &name) const {
    return find(wholes, name);
  }

 private:
  template <class Value>
  static const Value &find(const std::map<std::string, Value> &values, const std::string &name) {
    const auto at = values.find(name);
    if (at == values.end()) throw std::runtime_error("the saved state has no " + name);
    return at->second;
  }
};

}  // namespace flipflow
