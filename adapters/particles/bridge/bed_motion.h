#pragma once

#include <mpi.h>

#include <algorithm>
#include <cmath>

#include "atom.h"
#include "lammps.h"
#include "neighbor.h"

#include "../../vec3.h"
#include "saved_particles.h"

namespace flipflow {

// How the particles of all ranks moved since their neighbours were last listed: all by `common_m`, which is
// the middle of the box around their ways, and each by no more than `farthest_m` besides.
//
// A list of pairs does not care where a bed goes as a whole: a bed that is thrown or falls needs new lists
// only for how its particles move against each other.  Particles go to ranks side by side only, so that the
// common way counts up to half a cutoff.
struct BedMotion {
  Vec3 common_m = {0, 0, 0};
  double farthest_m = 0.0;

  // `enough_m`: a larger bound for the farthest is not good enough, and is replaced by the true one.
  BedMotion(LAMMPS_NS::LAMMPS &lmp, double enough_m) {
    const LAMMPS_NS::Atom &atom = *lmp.atom;
    double **const listed = listed_at(lmp);
    double most[6] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL, -HUGE_VAL, -HUGE_VAL, -HUGE_VAL};  // forth and back
    for (int i = 0; i < atom.nlocal; ++i)
      for (int c = 0; c < 3; ++c) {
        const double way_m = atom.x[i][c] - listed[i][c];
        most[c] = std::max(most[c], way_m);
        most[3 + c] = std::max(most[3 + c], -way_m);
      }
    MPI_Allreduce(MPI_IN_PLACE, most, 6, MPI_DOUBLE, MPI_MAX, lmp.world);
    if (most[0] == -HUGE_VAL) return;  // nobody is there
    const Vec3 forth = from(most), back = -1.0 * from(most + 3), middle = 0.5 * (forth + back);
    const double limit_m = 0.5 * lmp.neighbor->cutneighmax - lmp.neighbor->skin;
    common_m = std::min(1.0, limit_m / norm(middle)) * middle;
    farthest_m = 0.5 * norm(forth - back) + norm(middle - common_m);
    if (farthest_m <= enough_m) return;
    double farthest2 = 0.0;
    for (int i = 0; i < atom.nlocal; ++i) {
      const Vec3 besides = from(atom.x[i]) - from(listed[i]) - common_m;
      farthest2 = std::max(farthest2, dot(besides, besides));
    }
    MPI_Allreduce(MPI_IN_PLACE, &farthest2, 1, MPI_DOUBLE, MPI_MAX, lmp.world);
    farthest_m = std::sqrt(farthest2);
  }
};

}  // namespace flipflow
