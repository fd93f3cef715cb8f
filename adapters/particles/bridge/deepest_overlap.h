#pragma once

#include <algorithm>
#include <map>

namespace LAMMPS_NS {
class LAMMPS;
}

namespace flipflow {

// Of some contacts: the deepest, and the deepest against the (smaller) sphere's diameter.
struct DeepestOverlap {
  double depth_m = 0.0, share = 0.0;

  void add(double overlap_m, double radius_m) {
    depth_m = std::max(depth_m, overlap_m);
    if (overlap_m > share * 2.0 * radius_m) share = overlap_m / (2.0 * radius_m);
  }
};

// Of the particle-particle contacts of each LIGGGHTS instance, on this rank, in all its force
// evaluations since it was last set to nothing; the contact models fill it in.  Values stay where
// they are until their instance goes.
inline std::map<LAMMPS_NS::LAMMPS *, DeepestOverlap> deepest_between;

}  // namespace flipflow
