#pragma once

#include <algorithm>
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
#include "deck_contacts.h"
#include "fix_bodies.h"
#include "surface_path.h"
#include "triangle.h"

namespace flipflow {

// Takes particles out of the run: those whose centre is in the box of an exit, and those that left
// the domain.  What leaves below the deck has come through it: where the deck reaches into such an exit, who
// is above it, or in one of its openings, stays.
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
    bool below_deck = false;

    bool holds(Vec3 place) const {
      const Vec3 from_center = place - center;
      for (int k = 0; k < 3; ++k)
        if (std::abs(dot(from_center, axis[k])) > half[k]) return false;
      return true;
    }

    // Does the box around the triangle, along the edges, meet this one?
    bool may_meet(Vec3 a, Vec3 b, Vec3 c) const {
      for (int k = 0; k < 3; ++k) {
        const double x = dot(a - center, axis[k]), y = dot(b - center, axis[k]), z = dot(c - center, axis[k]);
        if (std::min({x, y, z}) > half[k] || std::max({x, y, z}) < -half[k]) return false;
      }
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
    std::vector<double> deck;  // its row of DeckContacts
    FixBodies::Row body;       // of single spheres nothing
  };

  FixExits(LAMMPS_NS::LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg) {}

  // The `deck` are the triangles of the `surface` below which particles have left it, with normals that point up.
  void set(std::vector<Box> exits, Vec3 low_m, Vec3 high_m, std::vector<Triangle> deck,
           const SurfacePath &surface, DeckContacts &contacts) {
    exits_ = std::move(exits);
    low_ = low_m;
    high_ = high_m;
    deck_ = std::move(deck);
    surface_ = &surface;
    contacts_ = &contacts;
  }

  // Bodies, all of whose spheres are at the centre by now, go as a whole.
  void know(const FixBodies *bodies) { bodies_ = bodies; }

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
    in_exit_.assign(exits_.size(), {});
    const size_t before = removed_.size();
    long spheres = 0;  // besides the first ones of bodies
    for (int i = atom->nlocal - 1; i >= 0; --i) {
      const Vec3 place = from(atom->x[i]);
      const int exit = exit_of(place);
      if (exit == kStays) continue;
      if (bodies_ && !bodies_->is_lead(i)) {
        remove(i);
        ++spheres;
        continue;
      }
      if (exit != kLost && exits_[exit].below_deck) contacts_->passes(*surface_, i, place);
      const double *deck = contacts_->row(i);
      removed_.push_back({atom->tag[i], atom->type[i], exit, update->ntimestep, velocity_behind, place,
                          from(atom->v[i]), from(atom->omega[i]), atom->radius[i],
                          atom->density[i], atom->rmass[i],
                          std::vector<double>(deck, deck + contacts_->width()),
                          bodies_ ? bodies_->row_of_atom(i) : FixBodies::Row{}});
      remove(i);
    }
    long gone = static_cast<long>(removed_.size() - before) + spheres;
    MPI_Allreduce(MPI_IN_PLACE, &gone, 1, MPI_LONG, MPI_SUM, world);
    atom->natoms -= gone;
    before_exchange_();
  }

  // -1: lost, -2: stays
  int exit_of(Vec3 place) {
    for (size_t e = 0; e < exits_.size(); ++e)
      if (exits_[e].holds(place) && !(exits_[e].below_deck && is_above(deck_in(e), place)))
        return static_cast<int>(e);
    const double x[3] = {place.x, place.y, place.z};
    const double low[3] = {low_.x, low_.y, low_.z}, high[3] = {high_.x, high_.y, high_.z};
    for (int k = 0; k < 3; ++k)
      if (!domain->periodicity[k] && (x[k] < low[k] || x[k] > high[k])) return kLost;
    return kStays;
  }

  // The triangles of the deck that reach into an exit, where the deck is now.
  const std::vector<Triangle> &deck_in(size_t e) {
    DeckInExit &found = in_exit_[e];
    if (!std::exchange(found.known, true))
      for (const Triangle &t : deck_)
        if (exits_[e].may_meet(surface_->position(t[0]), surface_->position(t[1]), surface_->position(t[2])))
          found.triangles.push_back(t);
    return found.triangles;
  }

  // Is a place on the upper side of the triangle that is nearest?  Of two that share the nearest point, the
  // one counts that sees the place more from the front.
  bool is_above(const std::vector<Triangle> &triangles, Vec3 place) const {
    constexpr double kAlike = 1e-9;
    double nearest = HUGE_VAL, height = -1.0;
    for (const Triangle &t : triangles) {
      const Vec3 a = surface_->position(t[0]), b = surface_->position(t[1]), c = surface_->position(t[2]);
      const ClosestPoint at = closest_point(place, a, b, c);
      const Vec3 nearest_m = at.weight[0] * a + at.weight[1] * b + at.weight[2] * c;
      const Vec3 away = place - nearest_m, normal = cross(b - a, c - a);
      const double distance = norm(away), up = dot(away, normal) / norm(normal);
      if (distance > nearest * (1.0 + kAlike)) continue;
      if (distance >= nearest * (1.0 - kAlike) && std::abs(up) <= std::abs(height)) continue;
      nearest = std::min(nearest, distance);
      height = up;
    }
    return height >= 0.0;
  }

  void remove(int i) {
    --atom->nlocal;
    if (i != atom->nlocal) atom->avec->copy(atom->nlocal, i, 1);
  }

  struct DeckInExit {
    bool known = false;
    std::vector<Triangle> triangles;
  };

  std::vector<Box> exits_;
  std::vector<Triangle> deck_;
  const SurfacePath *surface_ = nullptr;
  DeckContacts *contacts_ = nullptr;
  const FixBodies *bodies_ = nullptr;
  std::vector<DeckInExit> in_exit_;  // of each exit, found anew each time that particles are taken out
  Vec3 low_{}, high_{};
  std::vector<Removed> removed_;
  bool acts_at_next_setup_ = false;
  std::function<void()> before_exchange_ = [] {};
};

}  // namespace flipflow
