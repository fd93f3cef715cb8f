#pragma once

#include <vector>

#include "bending.h"
#include "maxwell.h"
#include "membrane.h"
#include "path.h"

namespace flipflow {

// All that changes while a sheet moves; arrays that Python owns.  (nodes, 3) each, and the
// parts' strains, elastic forces and stresses as in membrane.h and bending.h; `energy_J` (2,
// branches) of the membrane's and of bending's branches, `lost_J` (1) since the start.
struct SheetState {
  double *position_m, *velocity_m_per_s, *internal_N;
  double *strain, *strain_stress, *elastic_N, *bending_stress_N;
  double *energy_J, *lost_J;
};

// A thin sheet in velocity Verlet: Explicit of adapters/panel/finite_element/integrators.py on the structure of sheet_forms.py.
class Sheet {
 public:
  // `mobility_1_kg` (nodes), zero for the nodes `held`.
  Sheet(Membrane membrane, Bending bending, Branches branches, const double *mobility_1_kg,
        int nodes, std::vector<int> held);

  // Takes the positions as the shape in which every branch is relaxed.
  void rest(const SheetState &state);

  // Moves the state in `steps` steps under a constant force (nodes, 3).  Adds the internal force's
  // impulse (held, 3) and returns its work at the held nodes.
  double advance(const SheetState &state, const HeldPath &path, const double *outside_N, int steps,
                 double *impulse_N_s);

  double membrane_J(const double *position_m) const { return membrane_.energy_J(position_m); }
  int groups() const { return membrane_.groups(); }
  int branches() const { return branches_.count(); }
  int size() const { return static_cast<int>(mobility_.size()); }  // 3 * nodes
  int held() const { return static_cast<int>(held_.size()); }

 private:
  struct Works {
    StepWork stretching, bending;
  };

  Works find_force(const SheetState &state);
  void place_held(const SheetState &state, const HeldPath &path, double fraction) const;
  double collect(const SheetState &state, double step_s, double *impulse_N_s) const;

  Membrane membrane_;
  Bending bending_;
  Branches branches_;
  std::vector<double> mobility_;  // (nodes, 3)
  std::vector<int> held_;
  std::vector<double> before_m_, before_N_;  // (nodes, 3) at the step's start
};

}  // namespace flipflow
