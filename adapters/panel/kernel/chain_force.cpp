#include "chain_force.h"

#include <algorithm>
#include <cmath>

#include "vector3.h"

namespace flipflow {

ChainForce::ChainForce(ChainLinks links)
    : links_(std::move(links)),
      strain_(links_.strains()),
      over_(links_.strains()),
      direction_(3 * links_.springs()) {
  const double youngs_Pa = 6.0 * (links_.c10_Pa + links_.c01_Pa);
  for (const double area_m2 : links_.area_m2)
    stiffness_.push_back(youngs_Pa * area_m2 / links_.rest_m);
  for (const double bending_N_m3 : links_.bending_N_m3)
    stiffness_.insert(stiffness_.end(), 3, bending_N_m3);
}

StepWork ChainForce::step(const Branches &branches, const double *position_m, double *strain,
                          double *stress, double *force_N) {
  find_strain(position_m);
  const StepWork work = find_overstress(branches, strain, stress);
  for (int i = 0; i < links_.springs(); ++i) {
    const double stretch = strain_[i] / links_.rest_m, per_stretch = 1.0 / stretch;
    const double stress_Pa = 2.0 * (stretch - per_stretch * per_stretch) *
                             (links_.c10_Pa + links_.c01_Pa * per_stretch);
    const double tension_N = links_.area_m2[i] * stress_Pa + over_[i];
    double *first_N = force_N + 3 * (links_.first + i);
    add(tension_N, &direction_[3 * i], first_N);
    add(-tension_N, &direction_[3 * i], first_N + 3);
  }
  for (int k = 0; k < links_.bends(); ++k) {
    const int at = links_.springs() + 3 * k;
    double moment[3];
    for (int c = 0; c < 3; ++c) moment[c] = stiffness_[at + c] * strain_[at + c] + over_[at + c];
    for (int j = 0; j < 3; ++j) add(-links_.curvature_1_m2[3 * k + j], moment, force_N + 3 * (k + j));
  }
  return work;
}

void ChainForce::find_strain(const double *position_m) {
  for (int i = 0; i < links_.springs(); ++i) {
    const double *first_m = position_m + 3 * (links_.first + i);
    double *direction = &direction_[3 * i];
    for (int c = 0; c < 3; ++c) direction[c] = first_m[3 + c] - first_m[c];
    strain_[i] = std::sqrt(dot(direction, direction));
    for (int c = 0; c < 3; ++c) direction[c] /= strain_[i];
  }
  const double *along = links_.along.data();
  for (int k = 0; k < links_.bends(); ++k) {
    double *curvature = &strain_[links_.springs() + 3 * k];
    std::fill_n(curvature, 3, 0.0);
    for (int j = 0; j < 3; ++j)
      add(links_.curvature_1_m2[3 * k + j], position_m + 3 * (k + j), curvature);
    if (links_.at_clamp[k]) add(-dot(curvature, along), along, curvature);
  }
}

StepWork ChainForce::find_overstress(const Branches &branches, double *strain, double *stress) {
  StepWork work(branches.count());
  for (int i = 0; i < strains(); ++i) {
    const double change = strain_[i] - strain[i], push = stiffness_[i] * change;
    strain[i] = strain_[i];
    work.square_J += change * push;
    over_[i] = 0.0;
    for (int b = 0; b < branches.count(); ++b) {
      double &own = stress[b * strains() + i];
      work.cross_J[b] += own * change;
      own = branches.decay()[b] * own + branches.gain()[b] * push;
      over_[i] += branches.ratio()[b] * own;
    }
  }
  return work;
}

}  // namespace flipflow
