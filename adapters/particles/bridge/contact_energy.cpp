#include "contact_energy.h"

#include <mpi.h>

#include <algorithm>

#include "atom.h"
#include "force.h"
#include "lammps.h"
#include "neigh_list.h"
#include "pair_gran.h"
#include "../../vec3.h"
#include "fix_bodies.h"

namespace flipflow {

using namespace LAMMPS_NS;

namespace {

// The integral of `sjkr`'s area of contact over the overlap: a disc on a plane, or between spheres.
double sjkr_volume_m3(double ri, double rj, double overlap) {
  if (rj == 0.0) return M_PI * overlap * overlap * (ri - overlap / 3.0);
  const double sum = ri + rj, apart = sum - overlap, difference = ri - rj;
  return 0.25 * M_PI * overlap * overlap *
         ((apart + 2.0 * sum) / 3.0 - difference * difference / apart);
}

// Calls visit(i, j, overlap_m, history) for each pair of particles that touch, once.  One with a particle of
// another rank, or across a periodic side, has j behind the own particles, and comes once for each of both.
template <typename Visit>
void each_touching(LAMMPS &lmp, const ContactLaws &laws, Visit visit) {
  const Atom &atom = *lmp.atom;
  auto *pair = static_cast<PairGran *>(lmp.force->pair);
  const NeighList *list = pair->list, *histories = list->listgranhistory;
  const int values = pair->dnum_pair();
  for (int k = 0; k < list->inum; ++k) {
    const int i = list->ilist[k];
    for (int n = 0; n < list->numneigh[i]; ++n) {
      const int j = list->firstneigh[i][n] & NEIGHMASK;
      const double overlap_m =
          atom.radius[i] + atom.radius[j] - norm(from(atom.x[i]) - from(atom.x[j]));
      const double *history = values ? histories->firstdouble[i] + n * values : nullptr;
      if (laws.touching(overlap_m, history)) visit(i, j, overlap_m, history);
    }
  }
}

}  // namespace

ContactEnergy ContactLaws::stored(int type_i, int type_j, double radius_i_m, double radius_j_m,
                                  double overlap_m, const double *history) const {
  const int pair = (type_i - 1) * types + type_j - 1;
  const double reduced = radius_j_m == 0.0
                             ? radius_i_m
                             : radius_i_m * radius_j_m / (radius_i_m + radius_j_m);
  const Jkr law = jkr(type_i, type_j, reduced);
  const double neck = neck_m(reduced, overlap_m, history);
  ContactEnergy energy = {law.elastic_J(neck, overlap_m), law.adhesion_J(neck)};
  if (adhesion == Adhesion::sjkr)
    energy.adhesion_J = -strength[pair] * sjkr_volume_m3(radius_i_m, radius_j_m, overlap_m);
  if (tangential_spring) {
    const Vec3 stretch = from(history + spring());
    energy.elastic_J += 0.5 * 8.0 * g_star_Pa[pair] * neck * dot(stretch, stretch);
  }
  return energy;
}

ContactEnergy pair_energy(LAMMPS &lmp, const ContactLaws &laws) {
  const Atom &atom = *lmp.atom;
  ContactEnergy energy;
  each_touching(lmp, laws, [&](int i, int j, double overlap_m, const double *history) {
    energy.add(laws.stored(atom.type[i], atom.type[j], atom.radius[i], atom.radius[j], overlap_m,
                           history),
               j < atom.nlocal ? 1.0 : 0.5);
  });
  return energy;
}

std::vector<std::int64_t> contact_numbers(LAMMPS &lmp, const ContactLaws &laws) {
  std::vector<std::int64_t> numbers(lmp.atom->nlocal, 0);
  each_touching(lmp, laws, [&](int i, int j, double, const double *) {
    ++numbers[i];
    if (j < lmp.atom->nlocal) ++numbers[j];
  });
  return numbers;
}

std::vector<std::int64_t> contact_numbers(LAMMPS &lmp, const ContactLaws &laws, const FixBodies &bodies) {
  const Atom &atom = *lmp.atom;
  std::vector<std::vector<std::int64_t>> others(atom.nlocal);  // of each body, with its first sphere
  const auto touch = [&](int i, int j) {
    others[bodies.lead_of_atom(i)].push_back(bodies.body_of_tag(atom.tag[j]));
  };
  each_touching(lmp, laws, [&](int i, int j, double, const double *) {
    touch(i, j);
    if (j < atom.nlocal) touch(j, i);
  });
  std::vector<std::int64_t> numbers;
  for (int b = 0; b < bodies.count(); ++b) {
    std::vector<std::int64_t> &own = others[bodies.lead(b)];
    std::sort(own.begin(), own.end());
    numbers.push_back(std::unique(own.begin(), own.end()) - own.begin());
  }
  return numbers;
}

}  // namespace flipflow
