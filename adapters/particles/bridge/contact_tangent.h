#pragma once

#include <vector>

#include "atom.h"

#include "saved_state.h"
#include "surface_path.h"

namespace flipflow {

// How the load of this rank's particles answers to the surface's motion: the contacts of the last
// force evaluation, linear about their present place (docs/theory/coupling.md).
class ContactTangent {
 public:
  // Forces on the sphere; `normal` points to it.  `elastic` is `force` without dampers, and with what
  // goes through the sphere's centre; the contact point is `lever_m` from there.
  struct Contact {
    int sphere;
    Footing at;
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
  //
  // Spring and damper by the implicit midpoint rule: their mean force on the sphere is
  // elastic - z (u - surface velocity), z = k H / 2 + g, with the point's mean velocity u, which it
  // changes itself by H / 2 times the force.
  void predict(const LAMMPS_NS::Atom &atom, double length_s, std::vector<double> &push_N,
               std::vector<double> &impedance_N_s_per_m) const {
    const double half_s = 0.5 * length_s;
    for (const Contact &contact : contacts_) {
      const Point point = touching_point(atom, contact);
      double z[2], share[2];
      for (int d = 0; d < 2; ++d) {
        z[d] = contact.stiffness_N_per_m[d] * half_s + contact.damping_N_s_per_m[d];
        share[d] = 1.0 / (1.0 + z[d] * half_s * point.light_1_kg[d]);
      }
      const Vec3 n = contact.normal, free = point.velocity + half_s * point.acceleration;
      const auto split = [&](Vec3 a, double normal, double across) {
        const Vec3 along = dot(a, n) * n;
        return normal * along + across * (a - along);
      };
      const Vec3 push = split(free, share[0] * z[0], share[1] * z[1]) -
                        split(contact.elastic, share[0], share[1]);
      const Vec3 rows[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
      for (int k = 0; k < 4; ++k) {
        const int p = contact.at.point[k];
        add_to(&push_N[3 * p], contact.at.weight[k] * push);
        for (int d = 0; d < 3; ++d)
          add_to(&impedance_N_s_per_m[9 * p + 3 * d],
                 contact.at.weight[k] * split(rows[d], share[0] * z[0], share[1] * z[1]));
      }
    }
  }

  void save(SavedState &saved) const {
    auto &reals = saved.reals["contact_tangent"];
    auto &wholes = saved.wholes["contact_tangent_at"];
    for (const Contact &c : contacts_) {
      wholes.push_back(c.sphere);
      wholes.insert(wholes.end(), c.at.point, c.at.point + 4);
      reals.insert(reals.end(), c.at.weight, c.at.weight + 4);
      for (Vec3 v : {c.normal, c.force, c.elastic}) reals.insert(reals.end(), {v.x, v.y, v.z});
      reals.insert(reals.end(), c.stiffness_N_per_m, c.stiffness_N_per_m + 2);
      reals.insert(reals.end(), c.damping_N_s_per_m, c.damping_N_s_per_m + 2);
      reals.insert(reals.end(), {c.lever_m});
    }
  }

  void restore(const SavedState &saved) {
    const auto &reals = saved.real("contact_tangent");
    const auto &wholes = saved.whole("contact_tangent_at");
    contacts_.clear();
    for (size_t c = 0; 5 * c < wholes.size(); ++c) {
      const double *r = &reals[kReals * c];
      const auto *w = &wholes[5 * c];
      const auto whole = [&](int k) { return static_cast<int>(w[k]); };
      const Footing at = {{whole(1), whole(2), whole(3), whole(4)}, {r[0], r[1], r[2], r[3]}};
      contacts_.push_back({whole(0), at, from(r + 4), from(r + 7), from(r + 10), {r[13], r[14]},
                           {r[15], r[16]}, r[17]});
    }
  }

 private:
  static constexpr int kReals = 18;  // of a contact

  // A contact's own velocity for the mean over the interval, were its force not there: of the point
  // of the sphere that touches, which turns with it.
  struct Point {
    Vec3 velocity, acceleration;
    double light_1_kg[2];  // velocity that an impulse gives it, normal and tangential
  };

  static Point touching_point(const LAMMPS_NS::Atom &atom, const Contact &contact) {
    const int i = contact.sphere;
    const double mass = atom.rmass[i], radius = atom.radius[i], l = contact.lever_m;
    const double inertia = 0.4 * mass * radius * radius;
    const Vec3 n = contact.normal, turning = (1.0 / inertia) * from(atom.torque[i]);
    const double light[2] = {1.0 / mass, 1.0 / mass + l * l / inertia};
    const Vec3 normal = dot(contact.force, n) * n, across = contact.force - normal;
    return {from(atom.v[i]) - l * cross(from(atom.omega[i]), n),
            (1.0 / mass) * from(atom.f[i]) - l * cross(turning, n) - light[0] * normal -
                light[1] * across,
            {light[0], light[1]}};
  }

  bool asked_ = false;
  std::vector<Contact> contacts_;
};

}  // namespace flipflow
