#include "maxwell.h"

#include <algorithm>
#include <cmath>

namespace flipflow {

Branches::Branches(std::vector<double> ratio, std::vector<double> time_s)
    : ratio_(std::move(ratio)),
      time_s_(std::move(time_s)),
      decay_(ratio_.size()),
      gain_(ratio_.size()) {}

void Branches::set_step(double step_s) {
  if (step_s == step_s_) return;
  step_s_ = step_s;
  for (size_t i = 0; i < ratio_.size(); ++i) {
    decay_[i] = std::exp(-step_s / time_s_[i]);
    gain_[i] = -std::expm1(-step_s / time_s_[i]) * time_s_[i] / step_s;
  }
}

void Branches::set_relaxed() {
  step_s_ = 0.0;
  std::fill(decay_.begin(), decay_.end(), 0.0);
  std::fill(gain_.begin(), gain_.end(), 0.0);
}

double Branches::book(const StepWork &work, double *energy_J) const {
  double lost_J = 0.0;
  for (size_t i = 0; i < ratio_.size(); ++i) {
    const double a = gain_[i], d = decay_[i], times = time_s_[i] / step_s_;
    const double cross = work.cross_J[i], square = work.square_J;
    const double done_J = ratio_[i] * (times * (1.0 - a) * square + a * cross);
    const double stored_J =
        d * d * energy_J[i] + ratio_[i] * (a * d * cross + 0.5 * a * a * square);
    lost_J += done_J + energy_J[i] - stored_J;
    energy_J[i] = stored_J;
  }
  return lost_J;
}

}  // namespace flipflow
