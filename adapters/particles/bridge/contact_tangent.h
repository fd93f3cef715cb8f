#pragma once

#include <vector>

#include "saved_state.h"
#include "triangle_grid.h"
#include "vec3.h"

namespace LAMMPS_NS {
class Atom;
}

namespace flipflow {

// How the load of this rank's particles answers to the surface's motion: the contacts of the last
// force evaluation, linear about their present place (docs/theory/coupling.md).
class ContactTangent {
 public:
  // Forces on the sphere; `normal` points to it.  `elastic` is `force` without dampers, and with what
  // goes through the sphere's centre; the contact point is `lever_m` from there.
  struct Contact {
    int sphere;
    Triangle corner;
    double weight[3];
    Vec3 normal, force, elastic;
    double stiffness_N_per_m[2], damping_N_s_per_m[2];  // normal, tangential
    double lever_m;
  };

  void ask() { asked_ = true; }
  bool asked() const { return asked_; }
  void clear() { contacts_.clear(); }
  void add(const Contact &contact) { contacts_.push_back(contact); }

  // Mean load over the next `length_s` while the surface points keep a velocity:
  // push (3 * points) - impedance (9 * points) velocity.  Adds to both.
  void predict(const LAMMPS_NS::Atom &atom, double length_s, std::vector<double> &push_N,
               std::vector<double> &impedance_N_s_per_m) const;

  void save(SavedState &saved) const;
  void restore(const SavedState &saved);

 private:
  bool asked_ = false;
  std::vector<Contact> contacts_;
};

}  // namespace flipflow
