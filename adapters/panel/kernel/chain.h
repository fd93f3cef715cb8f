#pragma once

#include <vector>

#include "chain_force.h"
#include "maxwell.h"
#include "path.h"

namespace flipflow {

// Rows of a chain and how they are held.
struct ChainRows {
  std::vector<double> mass_kg;    // (rows)
  std::vector<int> held, free;    // rows
  std::vector<double> across;     // (3) unit vector across the strip
  std::vector<double> share;      // (rows, held): how rows follow the held ones across

  int count() const { return static_cast<int>(mass_kg.size()); }
};

// All that changes while a chain moves; arrays that Python owns.  (rows, 3) each; the others as in
// chain_force.h; `energy_J` (branches), `lost_J` (1) since the start.
struct ChainState {
  double *position_m, *velocity_m_per_s, *internal_N;
  double *strain, *stress, *energy_J, *lost_J;
};

// A chain in motion: velocity Verlet with Maxwell branches.  Across, free rows follow the held ones
// linearly, and what pushes them across goes to the held ones at once
// (docs/theory/panel_strip.md).
class Chain {
 public:
  Chain(ChainForce force, ChainRows rows, Branches branches);

  int size() const { return 3 * rows_.count(); }
  int held() const { return static_cast<int>(rows_.held.size()); }
  int strains() const { return force_.strains(); }
  int branches() const { return branches_.count(); }

  // Takes the positions as the shape in which every branch is relaxed.
  void rest(const ChainState &state);

  // Moves the state in `steps` steps under a constant force (rows, 3).  Adds the impulse (held, 3)
  // that the chain gives to the held rows, and returns its work on them.
  double advance(const ChainState &state, const HeldPath &path, const double *outside_N, int steps,
                 double *impulse_N_s);

 private:
  StepWork find_force(const ChainState &state);
  void kick(const ChainState &state, double half_step_s, const double *outside_N) const;
  void move(const ChainState &state, const HeldPath &path, double fraction, double step_s);
  void set_end_velocity(const ChainState &state, const HeldPath &path);
  double spread(int row) const;
  void onto_held(const double *rows, double *held) const;
  double work_J(const double *force_N, const double *moved_m) const;
  double imposed_J(const double *velocity_m_per_s);

  ChainForce force_;
  ChainRows rows_;
  Branches branches_;
  std::vector<double> before_m_, before_N_, start_m_per_s_, impulse_N_s_, acting_;  // (rows, 3)
  std::vector<double> moved_across_;                                            // (held)
};

}  // namespace flipflow
