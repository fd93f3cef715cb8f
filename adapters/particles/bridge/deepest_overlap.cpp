#include "deepest_overlap.h"

#include <map>

namespace flipflow {

namespace {

std::map<LAMMPS_NS::LAMMPS *, DeepestOverlap> &of_instances() {
  static std::map<LAMMPS_NS::LAMMPS *, DeepestOverlap> all;  // its values stay where they are
  return all;
}

}  // namespace

DeepestOverlap &deepest_between(LAMMPS_NS::LAMMPS &lmp) { return of_instances()[&lmp]; }

void forget_deepest_between(LAMMPS_NS::LAMMPS &lmp) { of_instances().erase(&lmp); }

}  // namespace flipflow
