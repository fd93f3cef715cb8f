#pragma once

#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "atom.h"
#include "atom_vec.h"
#include "domain.h"
#include "fix.h"
#include "update.h"

#include "../../vec3.h"

namespace flipflow {

// Takes particles out of the run: those whose centre is in the box of an exit, and those that left
// the domain.
//
// It acts where LIGGGHTS is about to sort particles and to list neighbours anew, so it costs a
// look at each particle then and nothing else.  A particle is out at the latest when it, or any
// other, has moved half the largest diameter since the last listing (BedMotion in fix_surface.cpp).
// Neighbours are listed between two runs, too, where new particles have come (Engine::prepare).
class FixExits : public LAMMPS_NS::Fix {
 public:
  struct Box {
    Vec3 center, axis[3];  // unit vectors along the edges
    double half[3];        // half the edges' lengths, m

    bool holds(Vec3 place) const {
      const Vec3 from_center = place - center;
      for (int k = 0; k < 3; ++k)
        if (std::abs(dot(from_center, axis[k])) > half[k]) return false;
      return true;
    }
  };

  // A particle as it was: its place at the end of `step`, its velocity so many steps before.
  struct Removed {
    int tag, type, exit;  // exit -1: left the domain
    LAMMPS_NS::bigint step;
    double velocity_behind;  // half a step inside of a run, none between two runs
    Vec3 position_m, velocity_m_per_s, spin_rad_per_s;
    double radius_m, density_kg_per_m3, mass_kg;
  };

  FixExits(LAMMPS_NS::LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg) {}

  void set(std::vector<Box> exits, Vec3 low_m, Vec3 high_m) {
    exits_ = std::move(exits);
    low_ = low_m;
    high_ = high_m;
  }

  // What else is to be done before particles go to other ranks.
  void before_exchange(std::function<void()> act) { before_exchange_ = std::move(act); }

  int setmask() override { return LAMMPS_NS::FixConst::PRE_EXCHANGE; }

  // LIGGGHTS calls its fixes of contact history before all others here, so that the history of who
  // stays is with the particles by now.
  void pre_exchange() override { take_out(0.5); }

  // LIGGGHTS calls this before each listing outside of a run, also where it only puts histories aside.
  void setup_pre_exchange() override {
    if (std::exchange(acts_at_next_setup_, false)) take_out(0.0);
  }
  void act_at_next_setup() { acts_at_next_setup_ = true; }

  // since last taken
  std::vector<Removed> take() { return std::exchange(removed_, {}); }
  long removed() const { return static_cast<long>(removed_.size()); }

 private:
  static constexpr int kLost = -1, kStays = -2;

  void take_out(double velocity_behind) {
    const size_t before = removed_.size();
    for (int i = atom->nlocal - 1; i >= 0; --i) {
      const Vec3 place = from(atom->x[i]);
      const int exit = exit_of(place);
      if (exit == kStays) continue;
      removed_.push_back({atom->tag[i], atom->type[i], exit, update->ntimestep, velocity_behind, place,
                          from(atom->v[i]), from(atom->omega[i]), atom->radius[i],
                          atom->density[i], atom->rmass[i]});
      remove(i);
    }
    long gone = static_cast<long>(removed_.size() - before);
    MPI_Allreduce(MPI_IN_PLACE, &gone, 1, MPI_LONG, MPI_SUM, world);
    atom->natoms -= gone;
    before_exchange_();
  }

  // -1: lost, -2: stays
  int exit_of(Vec3 place) const {
    for (size_t e = 0; e < exits_.size(); ++e)
      if (exits_[e].holds(place)) return static_cast<int>(e);
    const double x[3] = {place.x, place.y, place.z};
    const double low[3] = {low_.x, low_.y, low_.z}, high[3] = {high_.x, high_.y, high_.z};
    for (int k = 0; k < 3; ++k)
      if (!domain->periodicity[k] && (x[k] < low[k] || x[k] > high[k])) return kLost;
    return kStays;
  }

  void remove(int i) {
    --atom->nlocal;
    if (i != atom->nlocal) atom->avec->copy(atom->nlocal, i, 1);
  }

  std::vector<Box> exits_;
  Vec3 low_{}, high_{};
  std::vector<Removed> removed_;
  bool acts_at_next_setup_ = false;
  std::function<void()> before_exchange_ = [] {};
};

}  // namespace flipflow
