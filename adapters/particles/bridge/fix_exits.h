#pragma once

#include <vector>

#include "fix.h"
#include "vec3.h"

namespace flipflow {

// Takes particles out of the run: those whose centre is in the box of an exit, and those that left
// the domain.
//
// It acts where LIGGGHTS is about to sort particles and to list neighbours anew, so it costs a
// look at each particle then and nothing else.  A particle is out at the latest when it, or any
// other, has moved half a skin since the last listing.
class FixExits : public LAMMPS_NS::Fix {
 public:
  struct Box {
    Vec3 center, axis[3];  // unit vectors along the edges
    double half[3];        // half the edges' lengths, m
  };

  // A particle as it was: its place at the end of `step`, its velocity half a step before.
  struct Removed {
    int tag, type, exit;  // exit -1: left the domain
    LAMMPS_NS::bigint step;
    Vec3 position_m, velocity_m_per_s, spin_rad_per_s;
    double radius_m, density_kg_per_m3, mass_kg;
  };

  FixExits(LAMMPS_NS::LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg) {}

  void set(std::vector<Box> exits, Vec3 low_m, Vec3 high_m);

  int setmask() override;
  void pre_exchange() override;

  std::vector<Removed> take();  // since last taken

 private:
  int exit_of(Vec3 place) const;  // -1: lost, -2: stays
  void remove(int i);

  std::vector<Box> exits_;
  Vec3 low_{}, high_{};
  std::vector<Removed> removed_;
};

}  // namespace flipflow
