#pragma once

#include <algorithm>
#include <cmath>
#include <map>

#include "../../vec3.h"
#include "fix_bodies.h"

namespace LAMMPS_NS {
class LAMMPS;
}

namespace flipflow {

// The bodies of a LIGGGHTS instance, where there are any.
inline std::map<const LAMMPS_NS::LAMMPS *, const FixBodies *> bodies_of;

// The contacts that a body has with one other body, or with the surface, and the mass by which they are damped.
//
// A body that touches at one place turns as it is stopped there: the mass that acts is  1 / (1/m + t . I^-1 t)
// with the normal's moment t about the centre (W. J. Stronge, Impact Mechanics, 2000, chapter 3).  Contacts at
// several places stop the same bodies together.  Rayleigh's quotient of the motion that they see, closing at
// v_k against stiffnesses S_k, is its frequency,
//
//   omega^2 = (p . p / m + T . I^-1 T of both bodies) / sum S_k v_k^2,   p = sum S_k v_k n_k,  T = sum S_k v_k t_k,
//
// and a damper S_k / omega of each contact has the same share of the critical damping as one contact has by
// itself.  That is exact where the bodies meet with one motion of their own: flat or rocking.
class SharedContacts {
 public:
  // Forces on the first body; what the normal turns, of the body itself and of the other one.
  struct Contact {
    Vec3 normal, turned, other_turned;
    double stiffness, closing_m_per_s;
  };

  void add(const Contact &contact) {
    const double push = contact.stiffness * contact.closing_m_per_s;
    push_ = push_ + push * contact.normal;
    turned_ = turned_ + push * contact.turned;
    other_turned_ = other_turned_ + push * contact.other_turned;
    power_ += push * contact.closing_m_per_s;
    ++number_;
  }

  int number() const { return number_; }

  // Of one of them, no more than `reduced_kg` of bodies that do not turn.  `turning(T, T')`: the sum of
  // T . I^-1 T  of both bodies.
  template <class Turning>
  double mass_kg(double stiffness, double reduced_kg, Turning turning) const {
    const double freely = dot(push_, push_) / reduced_kg + turning(turned_, other_turned_);
    return stiffness * power_ < reduced_kg * freely ? stiffness * power_ / freely : reduced_kg;
  }

 private:
  Vec3 push_ = {0, 0, 0}, turned_ = {0, 0, 0}, other_turned_ = {0, 0, 0};
  double power_ = 0.0;
  int number_ = 0;
};

}  // namespace flipflow
