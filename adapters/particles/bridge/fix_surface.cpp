#include "fix_surface.h"

#include <algorithm>

#include "atom.h"
#include "comm.h"
#include "fix.h"
#include "granular_wall.h"
#include "neighbor.h"
#include "update.h"

namespace flipflow {

using namespace LAMMPS_NS;

namespace {

constexpr size_t kMostContacts = 16;  // deepest first; a sphere has no room for more

}  // namespace

FixSurface::FixSurface(LAMMPS *lmp, int narg, char **arg)
    : FixWallGran(lmp, narg, arg), surface_({}), history_(dnum()) {
  create_attribute = 1;
  atom->add_callback(0);
  comm->maxexchange_fix += history_.packed_size(kMostContacts);
  grow_arrays(atom->nmax);
  touch_all_ = [this, nothing = NoWear{}] { touch_all(nothing); };
}

FixSurface::~FixSurface() { atom->delete_callback(id, 0); }

int FixSurface::setmask() { return FixConst::PRE_NEIGHBOR | FixConst::POST_FORCE; }

int FixSurface::max_type() { return atom->ntypes; }

void FixSurface::set_surface(SurfacePath surface, std::vector<Triangle> triangles,
                             std::vector<int> type, double largest_radius_m) {
  surface_ = std::move(surface);
  type_ = std::move(type);
  largest_radius_ = largest_radius_m;
  search_.set(std::move(triangles), largest_radius_m);
  load_.set(surface_.points());
}

void FixSurface::set_wear(Wear wear) {
  wear_ = std::move(wear);
  touch_all_ = [this] { touch_all(wear_); };
}

void FixSurface::begin_path(const double *start_m, const double *start_m_s, const double *end_m,
                            const double *end_m_s, double length_s, int steps) {
  load_.jump(surface_, start_m);
  search_.surface_moved(surface_.begin(start_m, start_m_s, end_m, end_m_s, length_s));
  first_step_ = update->ntimestep;
  last_step_ = first_step_ + steps;
}

void FixSurface::save(SavedState &saved) const {
  saved.reals["surface_m"] = surface_.positions();
  search_.save(saved);
  history_.save(atom->nlocal, saved);
  load_.save(saved);
  response_.save(saved);
  wear_.save(saved);
  saved.reals["surface_energy_J"] = {energy_.elastic_J, energy_.adhesion_J};
  saved.reals["surface_deepest"] = {deepest_.depth_m, deepest_.share};
  saved.wholes["surface_contacts"] = {contacts_};
}

void FixSurface::restore(const SavedState &saved) {
  surface_.place(saved.real("surface_m"));
  search_.restore(saved);
  history_.restore(saved);
  load_.restore(saved);
  response_.restore(saved);
  wear_.restore(saved);
  const auto &energy = saved.real("surface_energy_J");
  energy_ = {energy[0], energy[1]};
  const auto &deepest = saved.real("surface_deepest");
  deepest_ = {deepest[0], deepest[1]};
  contacts_ = static_cast<int>(saved.whole("surface_contacts")[0]);
}

void FixSurface::setup(int flag) {
  neighbours_listed_now_ = true;
  post_force(flag);
}

void FixSurface::post_force(int) {
  computeflag_ = 1;
  shearupdate_ = update->setupflag ? 0 : 1;
  if (!update->setupflag) {
    const double step = static_cast<double>(update->ntimestep - first_step_);
    const double steps = static_cast<double>(last_step_ - first_step_);
    surface_.move(step / steps, (step - 0.5) / steps);
    search_.surface_moved(surface_.fastest_m_s() * update->dt);
  }
  if (neighbours_listed_now_ || search_.stale(neighbor->skin)) search();
  const bool last = update->setupflag || update->ntimestep == last_step_;
  load_.next_evaluation(last);
  responds_now_ = last && response_.asked();
  if (responds_now_) response_.clear();
  energy_ = {};
  deepest_ = {};
  contacts_ = 0;
  touch_all_();
}

template <class Worn>
void FixSurface::touch_all(Worn &worn) {
  for (const auto &near : search_.near()) touch(near, worn);
}

void FixSurface::search() {
  const Spheres spheres = {atom->x, atom->radius, atom->nlocal};
  search_.search(surface_, spheres, neighbor->contactDistanceFactor, neighbor->skin,
                 neighbours_listed_now_);
  neighbours_listed_now_ = false;
  auto near = search_.near().begin();
  for (int i = 0; i < atom->nlocal; ++i) {
    if (near != search_.near().end() && near->sphere == i)
      ++near;
    else
      history_.forget(i);
  }
}

template <class Worn>
void FixSurface::touch(const ContactSearch::Near &near, Worn &worn) {
  const int i = near.sphere;
  const double radius = atom->radius[i];
  search_.touches(surface_, near, from(atom->x[i]), radius * neighbor->contactDistanceFactor,
                  touches_);
  for (Touch &touch : touches_) touch.depth_m = radius - std::sqrt(touch.distance2);
  if (laws_.adhesion == ContactLaws::Adhesion::jkr) keep_necks(i);
  search_.share(surface_, touches_);
  if (touches_.size() > kMostContacts) touches_.resize(kMostContacts);
  history_.match(i, touches_);
  for (size_t k = 0; k < touches_.size(); ++k)
    push(i, touches_[k], dnum() > 0 ? history_.values(i, static_cast<int>(k)) : nullptr, worn);
}

// A contact that sticks lasts as long as its neck, whose depth counts from where it snaps; the neck
// goes along from triangle to triangle.
void FixSurface::keep_necks(int i) {
  history_.match(i, touches_);
  size_t kept = 0;
  for (size_t k = 0; k < touches_.size(); ++k) {
    Touch touch = touches_[k];
    const bool overlaps = touch.depth_m > 0, necked = history_.values(i, static_cast<int>(k))[0] > 0;
    touch.depth_m -= law(i, touch).separation_m();
    if (overlaps || (necked && touch.depth_m >= 0)) touches_[kept++] = touch;
  }
  touches_.resize(kept);
}

Jkr FixSurface::law(int i, const Touch &touch) const {
  return laws_.jkr(atom->type[i], type_[touch.triangle], atom->radius[i]);
}

// One contact through LIGGGHTS's own contact model.  What it added to the particle is measured,
// and scaled where contacts share a force; 8/15 E* sqrt(r) overlap^2.5 is Hertz's energy.  Verlet's
// velocities are those of the middle of the step while forces are evaluated: so is the surface's.
template <class Worn>
void FixSurface::push(int i, const Touch &touch, double *history, Worn &worn) {
  double *force = atom->f[i], *torque = atom->torque[i];
  const Vec3 force_before = from(force), torque_before = from(torque);
  const Triangle &corner = search_.triangle(touch.triangle);
  const double *w = touch.at.weight;
  Vec3 wall = w[0] * surface_.velocity_half_way(corner[0]) +
              w[1] * surface_.velocity_half_way(corner[1]) +
              w[2] * surface_.velocity_half_way(corner[2]);

  const double overlap = atom->radius[i] - std::sqrt(touch.distance2);
  LIGGGHTS::ContactModels::SurfacesIntersectData contact;
  contact.is_wall = true;
  contact.i = i;
  contact.radi = atom->radius[i];
  contact.deltan = overlap;
  contact.delta[0] = touch.away.x;
  contact.delta[1] = touch.away.y;
  contact.delta[2] = touch.away.z;
  contact.contact_history = history;
  atom_type_wall_ = type_[touch.triangle];
  const auto before = worn.before(history);
  impl->compute_force(this, contact, overlap > 0, &wall.x);

  Vec3 added = from(force) - force_before, turned = {0, 0, 0};
  const Vec3 unshared = added;
  if (touch.weight < 1) {
    added = touch.weight * added;
    const double stiffness = 8.0 / 15.0 * law(i, touch).e_star_Pa * std::sqrt(atom->radius[i]);
    turned = stiffness * touch.turning;
    added = added + turned;
    put(force, force_before + added);
    put(torque, torque_before + touch.weight * (from(torque) - torque_before));
  }
  const double step = update->setupflag ? 0.0 : update->dt;
  const Vec3 wall_now = w[0] * surface_.velocity(corner[0]) + w[1] * surface_.velocity(corner[1]) +
                        w[2] * surface_.velocity(corner[2]);
  load_.add(corner, w, added, wall_now, step);
  deepest_.add(overlap, atom->radius[i]);
  if (laws_.touching(overlap, history)) {
    ++contacts_;
    if (responds_now_) respond(touch, contact, history, unshared, turned);
    worn.after(before, contact, history, corner, w, touch.weight, step);
    energy_.add(laws_.stored(atom->type[i], atom_type_wall_, atom->radius[i], 0.0, overlap, history),
                touch.weight);
  }
}

}  // namespace flipflow
