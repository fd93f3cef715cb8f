#include "fix_exits.h"

#include <cmath>
#include <utility>

#include "atom.h"
#include "atom_vec.h"
#include "domain.h"
#include "update.h"

namespace flipflow {

using namespace LAMMPS_NS;

namespace {

constexpr int kLost = -1, kStays = -2;

bool holds(const FixExits::Box &box, Vec3 place) {
  const Vec3 from_center = place - box.center;
  for (int k = 0; k < 3; ++k)
    if (std::abs(dot(from_center, box.axis[k])) > box.half[k]) return false;
  return true;
}

}  // namespace

void FixExits::set(std::vector<Box> exits, Vec3 low_m, Vec3 high_m) {
  exits_ = std::move(exits);
  low_ = low_m;
  high_ = high_m;
}

int FixExits::setmask() { return FixConst::PRE_EXCHANGE; }

// LIGGGHTS calls its fixes of contact history before all others here, so that the history of who
// stays is with the particles by now.
void FixExits::pre_exchange() {
  const size_t before = removed_.size();
  for (int i = atom->nlocal - 1; i >= 0; --i) {
    const Vec3 place = from(atom->x[i]);
    const int exit = exit_of(place);
    if (exit == kStays) continue;
    removed_.push_back({atom->tag[i], atom->type[i], exit, update->ntimestep, place,
                        from(atom->v[i]), from(atom->omega[i]), atom->radius[i],
                        atom->density[i], atom->rmass[i]});
    remove(i);
  }
  long gone = static_cast<long>(removed_.size() - before);
  MPI_Allreduce(MPI_IN_PLACE, &gone, 1, MPI_LONG, MPI_SUM, world);
  atom->natoms -= gone;
}

int FixExits::exit_of(Vec3 place) const {
  for (size_t e = 0; e < exits_.size(); ++e)
    if (holds(exits_[e], place)) return static_cast<int>(e);
  const double x[3] = {place.x, place.y, place.z};
  const double low[3] = {low_.x, low_.y, low_.z}, high[3] = {high_.x, high_.y, high_.z};
  for (int k = 0; k < 3; ++k)
    if (!domain->periodicity[k] && (x[k] < low[k] || x[k] > high[k])) return kLost;
  return kStays;
}

void FixExits::remove(int i) {
  --atom->nlocal;
  if (i != atom->nlocal) atom->avec->copy(atom->nlocal, i, 1);
}

std::vector<FixExits::Removed> FixExits::take() { return std::exchange(removed_, {}); }

}  // namespace flipflow
