#include "membrane.h"

#include <algorithm>
#include <numeric>

#include "biquadratic.h"
#include "membrane_pass.h"

namespace flipflow {

namespace {

FLIPFLOW_V4 void step_v4(const MembranePass &pass) { step_all<Eight>(pass); }
FLIPFLOW_V3 void step_v3(const MembranePass &pass) { step_all<Four>(pass); }
void step_any(const MembranePass &pass) { step_all<Two>(pass); }
auto *const step_here = fitting(step_v4, step_v3, step_any);

}  // namespace

Membrane::Membrane(const CellGrid &grid, const MembraneLaw &law)
    : groups_((grid.cells() + kLanes - 1) / kLanes),
      c10_N_per_m_(law.c10_N_per_m),
      c01_N_per_m_(law.c01_N_per_m),
      nodes_across_(grid.nodes_across()),
      perforated_(!law.rest.empty()) {
  const int across = static_cast<int>(grid.across_m.size());
  for (int n = 0; n < groups() * kLanes; ++n) {
    const int cell = std::min(n, grid.cells() - 1), lane = n % kLanes;
    const double s = grid.along_m[cell / across], y = grid.across_m[cell % across];
    CellGroup &group = groups_[n / kLanes];
    group.per_s2[lane] = 1.0 / (s * s);
    group.per_sy[lane] = 1.0 / (s * y);
    group.per_y2[lane] = 1.0 / (y * y);
    group.area[lane] = n < grid.cells() ? s * y : 0.0;
    group.corner[lane] = 2 * (cell / across) * nodes_across_ + 2 * (cell % across);
    for (int k = 0; k < 5; ++k) group.strain[k][lane] = law.strain[5 * cell + k];
    group.solid[lane] = law.solid[cell];
    for (int k = 0; k < 6; ++k) group.rest[k][lane] = perforated_ ? law.rest[6 * cell + k] : 0.0;
  }
}

MembranePass Membrane::pass() const {
  return {groups_.data(), groups(), nodes_across_, c10_N_per_m_, c01_N_per_m_, perforated_};
}

StepWork Membrane::step(const Branches &branches, const double *position_m, double *strain,
                        double *stress, double *force_N) const {
  std::vector<double> cross_J(branches.count() * kLanes);
  double square_J[kLanes] = {};
  MembranePass step = pass();
  step.branches = &branches;
  step.position_m = position_m;
  step.strain = strain;
  step.stress = stress;
  step.force_N = force_N;
  step.cross_J = cross_J.data();
  step.square_J = square_J;
  step_here(step);
  StepWork work(branches.count());
  for (size_t i = 0; i < cross_J.size(); ++i) work.cross_J[i / kLanes] += cross_J[i];
  work.square_J = std::accumulate(square_J, square_J + kLanes, 0.0);
  return work;
}

double Membrane::energy_J(const double *position_m) const {
  MembranePass rest = pass();
  rest.position_m = position_m;
  return energy_all<Two>(rest);
}

}  // namespace flipflow
