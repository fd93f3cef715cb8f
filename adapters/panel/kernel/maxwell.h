#pragma once

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "lanes.h"

namespace flipflow {

// Work that the branches' energies follow from, by lanes: `cross_J` (branches, kLanes), each branch's old
// stress times the change of strain; `square_J`, the change of elastic stress times that of strain.
struct StepWork {
  explicit StepWork(int branches) : cross_J(branches * kLanes) {}
  std::vector<double> cross_J;
  double square_J[kLanes] = {};

  static double sum(const double *lanes_J) { return std::accumulate(lanes_J, lanes_J + kLanes, 0.0); }
};

// Maxwell branches over steps of one length: the update and the books of adapters/panel/common/maxwell.py.
// A branch's `stress` is its overstress divided by its ratio;
//   stress <- decay * stress + gain * (change of the elastic stress).
class Branches {
 public:
  Branches(std::vector<double> ratio, std::vector<double> time_s)
      : ratio_(std::move(ratio)),
        time_s_(std::move(time_s)),
        decay_(ratio_.size()),
        gain_(ratio_.size()) {}

  int count() const { return static_cast<int>(ratio_.size()); }
  const double *ratio() const { return ratio_.data(); }
  const double *decay() const { return decay_.data(); }
  const double *gain() const { return gain_.data(); }

  void set_step(double step_s) {
    if (step_s == step_s_) return;
    step_s_ = step_s;
    for (size_t i = 0; i < ratio_.size(); ++i) {
      decay_[i] = std::exp(-step_s / time_s_[i]);
      gain_[i] = -std::expm1(-step_s / time_s_[i]) * time_s_[i] / step_s;
    }
  }

  // Nothing is answered: for a shape in which every branch is at rest.
  void set_relaxed() {
    step_s_ = 0.0;
    std::fill(decay_.begin(), decay_.end(), 0.0);
    std::fill(gain_.begin(), gain_.end(), 0.0);
  }

  // Carries the stored energies (branches) over a step and returns what the step lost.
  double book(const StepWork &work, double *energy_J) const {
    const double square = StepWork::sum(work.square_J);
    double lost_J = 0.0;
    for (size_t i = 0; i < ratio_.size(); ++i) {
      const double a = gain_[i], d = decay_[i], times = time_s_[i] / step_s_;
      const double cross = StepWork::sum(work.cross_J.data() + i * kLanes);
      const double done_J = ratio_[i] * (times * (1.0 - a) * square + a * cross);
      const double stored_J =
          d * d * energy_J[i] + ratio_[i] * (a * d * cross + 0.5 * a * a * square);
      lost_J += done_J + energy_J[i] - stored_J;
      energy_J[i] = stored_J;
    }
    return lost_J;
  }

 private:
  std::vector<double> ratio_, time_s_, decay_, gain_;
  double step_s_ = 0.0;
};

}  // namespace flipflow
