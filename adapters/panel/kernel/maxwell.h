#pragma once

#include <vector>

namespace flipflow {

// Work that the branches' energies follow from: `cross_J` (branches), each branch's old stress times
// the change of strain; `square_J`, the change of elastic stress times that of strain.
struct StepWork {
  explicit StepWork(int branches) : cross_J(branches) {}
  std::vector<double> cross_J;
  double square_J = 0.0;
};

// Maxwell branches over steps of one length: the update and the books of adapters/panel/common/maxwell.py.
// A branch's `stress` is its overstress divided by its ratio;
//   stress <- decay * stress + gain * (change of the elastic stress).
class Branches {
 public:
  Branches(std::vector<double> ratio, std::vector<double> time_s);

  int count() const { return static_cast<int>(ratio_.size()); }
  const double *ratio() const { return ratio_.data(); }
  const double *decay() const { return decay_.data(); }
  const double *gain() const { return gain_.data(); }

  void set_step(double step_s);
  void set_relaxed();  // nothing is answered: for a shape in which every branch is at rest

  // Carries the stored energies (branches) over a step and returns what the step lost.
  double book(const StepWork &work, double *energy_J) const;

 private:
  std::vector<double> ratio_, time_s_, decay_, gain_;
  double step_s_ = 0.0;
};

}  // namespace flipflow
