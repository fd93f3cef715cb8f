#include "deepest_overlap.h"

#include <mpi.h>

#include "atom.h"
#include "force.h"
#include "lammps.h"
#include "neigh_list.h"
#include "pair_gran.h"
#include "vec3.h"

namespace flipflow {

using namespace LAMMPS_NS;

DeepestOverlap deepest_between(LAMMPS &lmp) {
  const Atom &atom = *lmp.atom;
  const NeighList *list = static_cast<PairGran *>(lmp.force->pair)->list;
  DeepestOverlap deepest;
  for (int k = 0; k < list->inum; ++k) {
    const int i = list->ilist[k];
    for (int n = 0; n < list->numneigh[i]; ++n) {
      const int j = list->firstneigh[i][n] & NEIGHMASK;
      const double apart_m = norm(from(atom.x[i]) - from(atom.x[j]));
      deepest.add(atom.radius[i] + atom.radius[j] - apart_m,
                  std::min(atom.radius[i], atom.radius[j]));
    }
  }
  return deepest;
}

}  // namespace flipflow
