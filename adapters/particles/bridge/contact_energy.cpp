#include "contact_energy.h"

#include <mpi.h>

#include "atom.h"
#include "force.h"
#include "lammps.h"
#include "neigh_list.h"
#include "pair_gran.h"
#include "vec3.h"

namespace flipflow {

using namespace LAMMPS_NS;

double pair_elastic_energy_J(LAMMPS &lmp, const std::vector<double> &e_star_Pa,
                             const std::vector<double> &g_star_Pa, bool tangential_spring) {
  const Atom &atom = *lmp.atom;
  auto *pair = static_cast<PairGran *>(lmp.force->pair);
  const NeighList *list = pair->list;
  const int values = tangential_spring ? pair->dnum_pair() : 0;
  double energy = 0.0;
  for (int k = 0; k < list->inum; ++k) {
    const int i = list->ilist[k];
    for (int n = 0; n < list->numneigh[i]; ++n) {
      const int j = list->firstneigh[i][n] & NEIGHMASK;
      const double ri = atom.radius[i], rj = atom.radius[j];
      const Vec3 apart = from(atom.x[i]) - from(atom.x[j]);
      const double overlap = ri + rj - norm(apart);
      if (overlap <= 0) continue;
      const int materials = (atom.type[i] - 1) * atom.ntypes + atom.type[j] - 1;
      const double root = std::sqrt(ri * rj / (ri + rj) * overlap);
      double one = 0.4 * (4.0 / 3.0) * e_star_Pa[materials] * root * overlap * overlap;
      if (tangential_spring) {
        const Vec3 spring = from(list->listgranhistory->firstdouble[i] + n * values);
        one += 0.5 * 8.0 * g_star_Pa[materials] * root * dot(spring, spring);
      }
      energy += j < atom.nlocal ? one : 0.5 * one;
    }
  }
  return energy;
}

}  // namespace flipflow
