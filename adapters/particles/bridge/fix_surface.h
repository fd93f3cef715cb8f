#pragma once

#include <mpi.h>

#include <functional>
#include <utility>
#include <vector>

#include "contact_interface.h"
#include "fix_wall_gran.h"

#include "contact_energy.h"
#include "contact_history.h"
#include "contact_tangent.h"
#include "contact_search.h"
#include "deck_contacts.h"
#include "deepest_overlap.h"
#include "fix_bodies.h"
#include "jkr.h"
#include "shared_contacts.h"
#include "surface_load.h"
#include "surface_path.h"
#include "wear.h"

namespace flipflow {

// The triangulated surface that particles touch, as a LIGGGHTS wall.
//
// The stock constructor of fix wall/gran sets up the contact model that the input names; here
// every force evaluation hands it the contacts found on our own surface, so that each model of
// LIGGGHTS acts on the surface as on a stock wall.  Every rank holds the whole surface and serves
// its own particles; contact history stays with the particles when they change place or rank.
class FixSurface : public LAMMPS_NS::FixWallGran {
 public:
  FixSurface(LAMMPS_NS::LAMMPS *lmp, int narg, char **arg);
  ~FixSurface() override;

  // `type` is the LIGGGHTS atom type of each triangle's material.
  void set_surface(SurfacePath surface, std::vector<Triangle> triangles, std::vector<int> type,
                   double largest_radius_m);
  void set_laws(const ContactLaws &laws) { laws_ = laws; }

  // Particles are the spheres of bodies, which are counted and weighed as wholes.
  void know(FixBodies *bodies) { bodies_ = bodies; }
  void set_wear(Wear wear);

  // Counts contacts with a deck; `on_deck` tells of each triangle whether it belongs to a panel.
  void set_deck(DeckLine line, std::vector<char> on_deck);
  DeckContacts &deck_contacts() { return deck_contacts_; }

  // The surface goes on after `period_m` along y (see ContactSearch).
  void repeat(double period_m, std::vector<Triangle> joined) {
    search_.repeat(period_m, std::move(joined));
  }

  // The next `steps` steps follow a new path.
  void begin_path(const double *start_m, const double *start_m_per_s, const double *end_m,
                  const double *end_m_per_s, double length_s, int steps);
  int points() const { return surface_.points(); }
  int vertices() const { return surface_.vertices(); }
  const SurfacePath &path() const { return surface_; }
  LAMMPS_NS::bigint first_step() const { return first_step_; }  // before the path's first step
  void begin_sums(double step_s);
  void end_sums(double step_s);
  // Integral over time since t = 0 of the sum of mass times place, of this rank's particles, kg m s.
  Vec3 mass_moment_time() const { return mass_moment_time_; }

  // Is the surface, where it is now, nearer to a place than `reach_m`?
  bool reached(Vec3 place, double reach_m) const {
    return search_.reached(surface_, place, reach_m);
  }

  void save(SavedState &saved) const;
  void restore(const SavedState &saved);  // after the particles

  ContactTangent &tangent() { return tangent_; }

  const SurfaceLoad &load() const { return load_; }
  const Wear &wear() const { return wear_; }
  ContactEnergy energy() const { return energy_; }  // in surface contacts, last evaluation

  // A centre that changed the side of the surface through a triangle: where it was at the end of the
  // step.
  struct Crossing {
    int tag;
    LAMMPS_NS::bigint step;
    Vec3 position_m;
  };
  std::vector<Crossing> take_crossings() { return std::exchange(crossings_, {}); }  // since last taken
  long crossings() const { return static_cast<long>(crossings_.size()); }
  DeepestOverlap take_deepest() { return std::exchange(deepest_, {}); }  // since last taken

  int setmask() override;
  void post_create() override {}  // the base class would make a history for its primitive wall
  void pre_delete(bool) override {}
  void setup(int) override;
  void post_integrate() override;
  void pre_neighbor() override;
  void post_force(int) override;
  void post_force_pgl() override {}

  int min_type() override { return 1; }
  int max_type() override;
  double max_rad(int) override { return largest_radius_; }

  void grow_arrays(int most) override {
    history_.resize(most);
    deck_contacts_.resize(most);
  }
  void copy_arrays(int from, int to, int) override {
    history_.copy(from, to);
    deck_contacts_.copy(from, to);
  }
  void set_arrays(int i) override {
    history_.forget(i);
    deck_contacts_.forget(i);
  }
  int pack_exchange(int i, double *buffer) override {
    const int used = history_.pack(i, buffer);
    return used + deck_contacts_.pack(i, buffer + used);
  }
  int unpack_exchange(int i, double *buffer) override {
    const int used = history_.unpack(i, buffer);
    return used + deck_contacts_.unpack(i, buffer + used);
  }

 private:
  // What the surface gave a sphere in the last evaluation of a run.
  struct Given {
    int sphere;
    Vec3 force_N, torque_N_m;
  };
  // A place where a sphere of a body touches, and all places where the body does.
  struct BodyTouch {
    int sphere, number;  // of the touch among those of its sphere
    Touch touch;
    SharedContacts::Contact contact;
  };
  struct BodyTouches {
    SharedContacts contacts;
    int spheres = 0;
  };

  void evaluate();
  void push_again();
  void search();
  template <class Worn>
  void touch_all(Worn &worn);
  void fetch(const ContactSearch::Near &near) const;
  void find_touches(const ContactSearch::Near &near);
  template <class Worn>
  void push_sphere(int i, Worn &worn);
  void note_body(int i);
  SharedContacts::Contact contact_of_body(int i, const Touch &touch, const double *history) const;
  double damped_kg(const BodyTouch &of) const;
  template <class Worn>
  void push_bodies(Worn &worn);
  void keep_necks(int i);
  void weigh(double step_s);
  double step_length2(int i) const;
  Vec3 place_before(int i) const;
  void find_crossing(const ContactSearch::Near &near, double nearest2);
  void find_far_crossings();
  void add_crossing(int i);
  Jkr law(int i, const Touch &touch) const;
  void add_tangent(const Touch &touch, const LIGGGHTS::ContactModels::SurfacesIntersectData &contact,
               const double *history, Vec3 added, Vec3 turned);
  template <class Worn>
  void push(int i, const Touch &touch, double damped_kg, double *history, Worn &worn);
  double *values_of(int i, int contact) { return dnum() > 0 ? history_.values(i, contact) : nullptr; }

  SurfacePath surface_;
  std::vector<int> type_;
  double largest_radius_ = 0.0;
  ContactLaws laws_;

  FixBodies *bodies_ = nullptr;
  ContactSearch search_;
  std::vector<Touch> touches_;
  ContactHistory history_;
  DeckContacts deck_contacts_;
  std::vector<char> on_deck_;  // of each triangle; empty: nothing is counted
  SurfaceLoad load_;
  ContactTangent tangent_;
  Wear wear_;
  std::function<void()> touch_all_;  // with or without wear

  LAMMPS_NS::bigint first_step_ = 0, last_step_ = 0;
  bool neighbours_listed_now_ = true, last_evaluation_ = true, tangent_wanted_now_ = false;
  bool between_steps_ = true;  // velocities are those of now, and no time passes
  bool jumped_ = false;        // the surface, since the last evaluation
  std::vector<Given> given_;
  std::vector<BodyTouch> body_touches_;  // of this evaluation
  std::vector<BodyTouches> of_body_;     // of each body, with its first sphere; empty between evaluations
  ContactEnergy energy_;
  DeepestOverlap deepest_;
  std::vector<Crossing> crossings_;
  Vec3 mass_moment_ = {0, 0, 0}, mass_moment_time_ = {0, 0, 0};
};

}  // namespace flipflow
