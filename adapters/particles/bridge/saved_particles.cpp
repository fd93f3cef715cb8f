#include "saved_particles.h"

#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "atom.h"
#include "atom_vec.h"
#include "comm.h"
#include "fix.h"
#include "force.h"
#include "lammps.h"
#include "modify.h"
#include "neigh_list.h"
#include "neighbor.h"
#include "pair_gran.h"
#include "update.h"

namespace flipflow {

using namespace LAMMPS_NS;

namespace {

// A protected member of LIGGGHTS; naming it as a template argument of an explicit instantiation is allowed by
// the language.
double **Neighbor::*places_held();
template <double **Neighbor::*member>
struct PlacesHeld {
  friend double **Neighbor::*places_held() { return member; }
};
template struct PlacesHeld<&Neighbor::xhold>;

std::vector<double> rows(double **first, int count) {
  return count ? std::vector<double>(first[0], first[0] + 3 * count) : std::vector<double>();
}

template <class Value>
std::vector<Value> column(const Value *first, int count) {
  return {first, first + count};
}

std::vector<std::int64_t> whole_column(const int *first, int count) {
  return {first, first + count};
}

void put(const std::vector<double> &values, double **first) {
  if (!values.empty()) std::copy(values.begin(), values.end(), first[0]);
}

// To the bit: minus zero is a value.
bool blank(const double *values, int count) {
  static const double zero = 0.0;
  return std::all_of(values, values + count,
                     [](const double &value) { return !std::memcmp(&value, &zero, sizeof zero); });
}

// To the bit: a place that is another one by rounding may list other neighbours.
bool same(const std::vector<double> &values, const double *now) {
  return !std::memcmp(values.data(), now, values.size() * sizeof(double));
}

bool same(const std::vector<std::int64_t> &values, const int *now) {
  return std::equal(values.begin(), values.end(), now);
}

// Calls visit(number, flag, values, count) for every pair of the lists, in their order.
template <class Visit>
void each_pair(LAMMPS &lmp, Visit visit) {
  auto &pair = *static_cast<PairGran *>(lmp.force->pair);
  const NeighList &list = *pair.list, *kept = list.listgranhistory;
  if (!kept) return;  // a contact model without history
  const int values = pair.dnum_pair();
  std::int64_t number = 0;
  for (int k = 0; k < list.inum; ++k) {
    const int i = list.ilist[k];
    for (int n = 0; n < list.numneigh[i]; ++n)
      visit(number++, kept->firstneigh[i][n], kept->firstdouble[i] + n * values, values);
  }
}

void save_pairs(LAMMPS &lmp, SavedState &saved) {
  auto &number = saved.wholes["pair"], &touching = saved.wholes["pair_flag"];
  auto &history = saved.reals["pair_history"];
  each_pair(lmp, [&](std::int64_t pair, int flag, const double *values, int count) {
    if (!flag && blank(values, count)) return;
    number.push_back(pair);
    touching.push_back(flag);
    history.insert(history.end(), values, values + count);
  });
}

void restore_pairs(LAMMPS &lmp, const SavedState &saved) {
  const auto &number = saved.whole("pair"), &touching = saved.whole("pair_flag");
  const double *history = saved.real("pair_history").data();
  size_t next = 0;
  each_pair(lmp, [&](std::int64_t pair, int &flag, double *values, int count) {
    const bool is_saved = next < number.size() && number[next] == pair;
    flag = is_saved ? static_cast<int>(touching[next]) : 0;
    if (is_saved)
      std::copy_n(history + count * next++, count, values);
    else
      std::fill_n(values, count, 0.0);
  });
  if (next < number.size()) throw std::runtime_error("the saved pairs are not those of the lists");
}

}  // namespace

double **listed_at(LAMMPS &lmp) { return lmp.neighbor->*places_held(); }

int add_particle(LAMMPS &lmp, int id, int type, const double *position_m, double radius_m,
                 double density_kg_per_m3) {
  Atom &atom = *lmp.atom;
  double x[3];
  std::copy_n(position_m, 3, x);
  atom.avec->create_atom(type, x);
  const int i = atom.nlocal - 1;
  atom.tag[i] = id;
  atom.radius[i] = radius_m;
  atom.density[i] = density_kg_per_m3;
  atom.rmass[i] = 4.0 / 3.0 * M_PI * radius_m * radius_m * radius_m * density_kg_per_m3;
  for (int f = 0; f < lmp.modify->nfix; ++f)
    if (lmp.modify->fix[f]->create_attribute) lmp.modify->fix[f]->set_arrays(i);
  return i;
}

void save_particles(LAMMPS &lmp, SavedState &saved) {
  const Atom &atom = *lmp.atom;
  const int n = atom.nlocal;
  saved.reals["listed_at_m"] = rows(listed_at(lmp), n);
  saved.reals["position_m"] = rows(atom.x, n);
  saved.reals["velocity_m_per_s"] = rows(atom.v, n);
  saved.reals["spin_rad_per_s"] = rows(atom.omega, n);
  saved.reals["force_N"] = rows(atom.f, n);
  saved.reals["torque_N_m"] = rows(atom.torque, n);
  saved.reals["radius_m"] = column(atom.radius, n);
  saved.reals["density_kg_per_m3"] = column(atom.density, n);
  saved.wholes["id"] = whole_column(atom.tag, n);
  saved.wholes["type"] = whole_column(atom.type, n);
  saved.wholes["image"] = whole_column(atom.image, n);
  saved.wholes["step"] = {lmp.update->ntimestep, atom.nextsort};
  save_pairs(lmp, saved);
}

bool is_listed_as_saved(LAMMPS &lmp, const SavedState &saved) {
  const Atom &atom = *lmp.atom;
  const auto &id = saved.whole("id");
  const bool nobody = id.empty() && atom.nlocal == 0;
  int alike = nobody || (static_cast<int>(id.size()) == atom.nlocal && same(id, atom.tag) &&
                         same(saved.whole("type"), atom.type) &&
                         same(saved.real("radius_m"), atom.radius) &&
                         same(saved.real("listed_at_m"), listed_at(lmp)[0]));
  MPI_Allreduce(MPI_IN_PLACE, &alike, 1, MPI_INT, MPI_LAND, lmp.world);
  return alike;
}

void place_as_listed(LAMMPS &lmp, const SavedState &saved) {
  Atom &atom = *lmp.atom;
  atom.nlocal = atom.nghost = 0;
  const auto &id = saved.whole("id"), &type = saved.whole("type");
  const auto &at = saved.real("listed_at_m"), &radius = saved.real("radius_m"),
             &density = saved.real("density_kg_per_m3");
  for (size_t k = 0; k < id.size(); ++k)
    add_particle(lmp, static_cast<int>(id[k]), static_cast<int>(type[k]), &at[3 * k], radius[k],
                 density[k]);
  atom.natoms = atom.nlocal;
  MPI_Allreduce(MPI_IN_PLACE, &atom.natoms, 1, MPI_LMP_BIGINT, MPI_SUM, lmp.world);
  lmp.update->ntimestep = saved.whole("step")[0];
}

void go_on_as_saved(LAMMPS &lmp, const SavedState &saved) {
  Atom &atom = *lmp.atom;
  const auto &id = saved.whole("id"), &image = saved.whole("image");
  if (!std::equal(id.begin(), id.end(), atom.tag, atom.tag + atom.nlocal))
    throw std::runtime_error("the saved particles came into another order");
  std::copy(image.begin(), image.end(), atom.image);
  put(saved.real("position_m"), atom.x);
  put(saved.real("velocity_m_per_s"), atom.v);
  put(saved.real("spin_rad_per_s"), atom.omega);
  put(saved.real("force_N"), atom.f);
  put(saved.real("torque_N_m"), atom.torque);
  lmp.update->ntimestep = saved.whole("step")[0];
  atom.nextsort = saved.whole("step")[1];
  lmp.comm->forward_comm();
  restore_pairs(lmp, saved);
}

}  // namespace flipflow
