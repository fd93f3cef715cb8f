#pragma once

#include <cstdint>
#include <vector>

#include "jkr.h"

namespace LAMMPS_NS {
class LAMMPS;
}

namespace flipflow {

class FixBodies;

struct ContactEnergy {
  double elastic_J = 0.0, adhesion_J = 0.0;

  void add(ContactEnergy other, double share) {
    elastic_J += share * other.elastic_J;
    adhesion_J += share * other.adhesion_J;
  }
};

// What contacts store: Hertz's or JKR's elastic energy, the (negative) energy of adhesion, and the
// spring of LIGGGHTS's tangential model `history`.  Tables are row-major, types x types.
struct ContactLaws {
  enum class Adhesion { none, sjkr, jkr };

  int types = 0;
  std::vector<double> e_star_Pa, g_star_Pa;
  Adhesion adhesion = Adhesion::none;
  std::vector<double> strength;  // jkr: work of adhesion, J/m2; sjkr: energy density, J/m3
  bool tangential_spring = false;

  // Without a work of adhesion it is Hertz's.
  Jkr jkr(int type_i, int type_j, double reduced_radius_m) const {
    const int pair = (type_i - 1) * types + type_j - 1;
    const double work = adhesion == Adhesion::jkr ? strength[pair] : 0.0;
    return {e_star_Pa[pair], work, reduced_radius_m};
  }

  // Where the tangential spring is in a contact's history; -1 without one.
  int spring() const { return tangential_spring ? (adhesion == Adhesion::jkr ? 1 : 0) : -1; }

  // Radius of the contact area of a touching pair, as the contact model left it.
  double neck_m(double reduced_radius_m, double overlap_m, const double *history) const {
    return adhesion == Adhesion::jkr ? history[0] : std::sqrt(reduced_radius_m * overlap_m);
  }

  bool touching(double overlap_m, const double *history) const {
    return adhesion == Adhesion::jkr ? history[0] > 0.0 : overlap_m > 0.0;
  }

  // Of a touching pair; types count from 1, radius j is 0 for the surface.  `history` as the contact
  // model left it: with jkr the neck's radius, then the spring.
  ContactEnergy stored(int type_i, int type_j, double radius_i_m, double radius_j_m,
                       double overlap_m, const double *history) const;
};

// Of the particle-particle contacts of this rank; one with a particle of another rank counts half.
ContactEnergy pair_energy(LAMMPS_NS::LAMMPS &lmp, const ContactLaws &laws);

// The number of other particles that each particle of this rank touches.
std::vector<std::int64_t> contact_numbers(LAMMPS_NS::LAMMPS &lmp, const ContactLaws &laws);
// The number of other bodies that each body of this rank touches, however many of its spheres do.
std::vector<std::int64_t> contact_numbers(LAMMPS_NS::LAMMPS &lmp, const ContactLaws &laws,
                                          const FixBodies &bodies);

}  // namespace flipflow
