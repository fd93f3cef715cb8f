#include "fix_surface.h"

#include <algorithm>
#include <climits>
#include <cmath>

#include "atom.h"
#include "comm.h"
#include "fix.h"
#include "granular_wall.h"
#include "neighbor.h"
#include "update.h"

#include "saved_particles.h"
#include "step_end.h"

namespace flipflow {

using namespace LAMMPS_NS;

namespace {

constexpr size_t kMostContacts = 16;  // deepest first; a sphere has no room for more
constexpr size_t kAhead = 4;          // spheres whose data are on their way from memory

// How the particles of all ranks moved since their neighbours were last listed: all by `common_m`, which is
// the middle of the box around their ways, and each by no more than `farthest_m` besides.
//
// A list of pairs does not care where a bed goes as a whole: a bed that is thrown or falls needs new lists
// only for how its particles move against each other.  But with new lists particles also leave by exits and go
// to ranks side by side, so nobody moves by more than half the largest diameter in between.  Cases may have no
// exits that are thinner than that (THICKNESS in orchestrator/preflight/checks/bed.py).
struct BedMotion {
  Vec3 common_m = {0, 0, 0};
  double farthest_m = 0.0;

  // `most_m`: how far a particle may move besides; a bound for the farthest that is larger is replaced by the
  // true one.  `in_all_m`: how far it may move in all.
  BedMotion(LAMMPS &lmp, double most_m, double in_all_m) {
    const Atom &atom = *lmp.atom;
    double **const listed = listed_at(lmp);
    double way[6] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL, -HUGE_VAL, -HUGE_VAL, -HUGE_VAL};  // forth and back
    for (int i = 0; i < atom.nlocal; ++i)
      for (int c = 0; c < 3; ++c) {
        const double moved_m = atom.x[i][c] - listed[i][c];
        way[c] = std::max(way[c], moved_m);
        way[3 + c] = std::max(way[3 + c], -moved_m);
      }
    MPI_Allreduce(MPI_IN_PLACE, way, 6, MPI_DOUBLE, MPI_MAX, lmp.world);
    if (way[0] == -HUGE_VAL) return;  // nobody is there
    const Vec3 forth = from(way), back = -1.0 * from(way + 3), middle = 0.5 * (forth + back);
    common_m = std::min(1.0, (in_all_m - most_m) / norm(middle)) * middle;
    farthest_m = 0.5 * norm(forth - back) + norm(middle - common_m);
    if (farthest_m <= most_m) return;
    double farthest2 = 0.0;
    for (int i = 0; i < atom.nlocal; ++i) {
      const Vec3 besides = from(atom.x[i]) - from(listed[i]) - common_m;
      farthest2 = std::max(farthest2, dot(besides, besides));
    }
    MPI_Allreduce(MPI_IN_PLACE, &farthest2, 1, MPI_DOUBLE, MPI_MAX, lmp.world);
    farthest_m = std::sqrt(farthest2);
  }
};

}  // namespace

FixSurface::FixSurface(LAMMPS *lmp, int narg, char **arg)
    : FixWallGran(lmp, narg, arg), surface_({}), history_(dnum()) {
  create_attribute = force_reneighbor = 1;
  next_reneighbor = -1;
  neighbor->delay = INT_MAX;  // not LIGGGHTS but `post_integrate` looks whether neighbours are to be listed
  atom->add_callback(0);
  comm->maxexchange_fix += history_.packed_size(kMostContacts);
  grow_arrays(atom->nmax);
  touch_all_ = [this, nothing = NoWear{}] { touch_all(nothing); };
}

FixSurface::~FixSurface() { atom->delete_callback(id, 0); }

int FixSurface::setmask() {
  return FixConst::POST_INTEGRATE | FixConst::PRE_NEIGHBOR | FixConst::POST_FORCE;
}

int FixSurface::max_type() { return atom->ntypes; }

void FixSurface::set_surface(SurfacePath surface, std::vector<Triangle> triangles,
                             std::vector<int> type, double largest_radius_m) {
  surface_ = std::move(surface);
  type_ = std::move(type);
  largest_radius_ = largest_radius_m;
  search_.set(surface_, std::move(triangles), largest_radius_m);
  load_.set(surface_.points());
}

void FixSurface::set_wear(Wear wear) {
  wear_ = std::move(wear);
  touch_all_ = [this] { touch_all(wear_); };
}

void FixSurface::set_deck(DeckLine line, std::vector<char> on_deck) {
  deck_contacts_.set(std::move(line), atom->nmax);
  on_deck_ = std::move(on_deck);
  comm->maxexchange_fix += deck_contacts_.width();
}

void FixSurface::begin_path(const double *start_m, const double *start_m_per_s, const double *end_m,
                            const double *end_m_per_s, double length_s, int steps) {
  load_.jump(surface_, start_m);
  jumped_ = !surface_.is_at(start_m);
  search_.surface_moved(surface_.begin(start_m, start_m_per_s, end_m, end_m_per_s, length_s));
  first_step_ = update->ntimestep;
  last_step_ = first_step_ + steps;
}

void FixSurface::save(SavedState &saved) const {
  saved.reals["surface_m"] = surface_.positions();
  search_.save(saved);
  history_.save(atom->nlocal, saved);
  deck_contacts_.save(atom->nlocal, saved);
  load_.save(saved);
  tangent_.save(saved);
  wear_.save(saved);
  auto &given = saved.reals["surface_given"];
  auto &given_to = saved.wholes["surface_given_to"];
  for (const Given &of : given_) {
    given_to.push_back(of.sphere);
    for (Vec3 part : {of.force_N, of.torque_N_m}) given.insert(given.end(), {part.x, part.y, part.z});
  }
  saved.reals["surface_energy_J"] = {energy_.elastic_J, energy_.adhesion_J};
  for (Vec3 of : {mass_moment_, mass_moment_time_})
    for (double part : {of.x, of.y, of.z}) saved.reals["mass_moments"].push_back(part);
}

void FixSurface::restore(const SavedState &saved) {
  surface_.place(saved.real("surface_m"));
  search_.restore(saved);
  history_.restore(saved);
  deck_contacts_.restore(saved);
  load_.restore(saved);
  tangent_.restore(saved);
  wear_.restore(saved);
  const double *given = saved.real("surface_given").data();
  given_.clear();
  for (const std::int64_t sphere : saved.whole("surface_given_to")) {
    given_.push_back({static_cast<int>(sphere), from(given), from(given + 3)});
    given += 6;
  }
  jumped_ = false;
  const auto &energy = saved.real("surface_energy_J");
  energy_ = {energy[0], energy[1]};
  deepest_ = {};
  crossings_.clear();
  next_reneighbor = -1;  // a step that listed neighbours may come again, and list none
  const double *moments = saved.real("mass_moments").data();
  mass_moment_ = from(moments);
  mass_moment_time_ = from(moments + 3);
}

// Sum of mass times place, by which gravity gives the particles angular momentum.
void FixSurface::weigh(double step_s) {
  Vec3 sum = {0, 0, 0};
  for (int b = 0; bodies_ && b < bodies_->count(); ++b)
    sum = sum + bodies_->mass_kg(b) * bodies_->row(b).place;
  for (int i = 0; !bodies_ && i < atom->nlocal; ++i) sum = sum + atom->rmass[i] * from(atom->x[i]);
  mass_moment_ = sum;
  mass_moment_time_ = mass_moment_time_ + step_s * sum;
}

void FixSurface::begin_sums(double step_s) {
  if (jumped_) push_again();
  load_.begin(surface_, step_s);
  mass_moment_time_ = mass_moment_time_ + 0.5 * step_s * mass_moment_;
}

void FixSurface::end_sums(double step_s) {
  load_.end(step_s);
  mass_moment_time_ = mass_moment_time_ - 0.5 * step_s * mass_moment_;
  const double length_s = step_s * static_cast<double>(last_step_ - first_step_);
  using Grain = DeckContacts::Grain;
  const auto body = [this](int b) -> Grain {
    return {bodies_->lead(b), bodies_->row(b).place, bodies_->bounding_radius_m(b)};
  };
  const auto sphere = [this](int i) -> Grain { return {i, from(atom->x[i]), atom->radius[i]}; };
  if (bodies_)
    deck_contacts_.observe(surface_, bodies_->count(), body, length_s);
  else
    deck_contacts_.observe(surface_, atom->nlocal, sphere, length_s);
}

void FixSurface::post_integrate() {
  const double most_m = 0.5 * neighbor->skin;
  const BedMotion bed(*lmp, most_m, largest_radius_);
  search_.bed_moved(bed.common_m);
  if (bed.farthest_m > most_m) next_reneighbor = update->ntimestep;
}

void FixSurface::pre_neighbor() {
  neighbours_listed_now_ = true;
  search_.bed_moved({0, 0, 0});
}

void FixSurface::setup(int flag) {
  pre_neighbor();  // LIGGGHTS has listed neighbours and says so only here
  post_force(flag);
}

void FixSurface::post_force(int) {
  between_steps_ = update->setupflag;
  if (!between_steps_) {
    const double step = static_cast<double>(update->ntimestep - first_step_);
    const double steps = static_cast<double>(last_step_ - first_step_);
    surface_.move(step / steps, (step - 0.5) / steps);
    search_.surface_moved(surface_.fastest_m_per_s() * update->dt);
  }
  evaluate();
}

// The half step that follows goes by what the surface pushes with where it is now.
void FixSurface::push_again() {
  for (const Given &old : given_) {
    add_to(atom->f[old.sphere], -1.0 * old.force_N);
    add_to(atom->torque[old.sphere], -1.0 * old.torque_N_m);
  }
  between_steps_ = true;
  evaluate();
  if (bodies_) bodies_->gather();
}

void FixSurface::evaluate() {
  computeflag_ = 1;
  shearupdate_ = between_steps_ ? 0 : 1;
  if (neighbours_listed_now_ || search_.stale(neighbor->skin)) search();
  last_evaluation_ = between_steps_ || update->ntimestep == last_step_;
  load_.next_evaluation(last_evaluation_);
  tangent_wanted_now_ = last_evaluation_ && tangent_.asked();
  if (tangent_wanted_now_) tangent_.clear();
  energy_ = {};
  given_.clear();
  jumped_ = false;
  touch_all_();
  load_.end_evaluation(between_steps_ ? 0.0 : update->dt);
  weigh(between_steps_ ? 0.0 : update->dt);
}

template <class Worn>
void FixSurface::touch_all(Worn &worn) {
  const auto &near = search_.near();
  for (size_t k = 0; k < near.size(); ++k) {
    if (k + 2 * kAhead < near.size()) history_.fetch_place(near[k + 2 * kAhead].sphere);
    if (k + kAhead < near.size()) fetch(near[k + kAhead]);
    find_touches(near[k]);
    if (touches_.empty()) continue;
    if (bodies_)
      note_body(near[k].sphere);
    else
      push_sphere(near[k].sphere, worn);
  }
  if (bodies_) push_bodies(worn);
}

// Asks memory for what is soon wanted of a sphere.
void FixSurface::fetch(const ContactSearch::Near &near) const {
  const int i = near.sphere;
  history_.fetch(i);
  search_.fetch(near);
  for (const double *const *of : {atom->x, atom->v, atom->omega, atom->f, atom->torque})
    __builtin_prefetch(of[0] + 3 * i);
}

void FixSurface::search() {
  find_far_crossings();
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

// Where a sphere touches, with what its contacts remember.
void FixSurface::find_touches(const ContactSearch::Near &near) {
  const int i = near.sphere;
  const double radius = atom->radius[i];
  const double nearest2 =
      search_.find_touches(surface_, near, from(atom->x[i]), radius * neighbor->contactDistanceFactor,
                      touches_);
  find_crossing(near, nearest2);
  for (Touch &touch : touches_) touch.depth_m = radius - std::sqrt(touch.distance2);
  const bool sticks = laws_.adhesion == ContactLaws::Adhesion::jkr;
  if (sticks) keep_necks(i);
  search_.share(surface_, touches_);
  if (touches_.size() > kMostContacts) touches_.resize(kMostContacts);
  if (sticks)
    history_.keep(i, touches_);
  else
    history_.match(i, touches_);
}

template <class Worn>
void FixSurface::push_sphere(int i, Worn &worn) {
  const Given before = {i, from(atom->f[i]), from(atom->torque[i])};
  for (size_t k = 0; k < touches_.size(); ++k)
    push(i, touches_[k], atom->rmass[i], values_of(i, static_cast<int>(k)), worn);
  if (last_evaluation_)
    given_.push_back({i, from(atom->f[i]) - before.force_N, from(atom->torque[i]) - before.torque_N_m});
}

// The touches of a sphere, among those of its body.
void FixSurface::note_body(int i) {
  of_body_.resize(atom->nlocal);
  BodyTouches &all = of_body_[bodies_->lead_of_atom(i)];
  bool presses = false;
  for (size_t k = 0; k < touches_.size(); ++k) {
    const int number = static_cast<int>(k);
    SharedContacts::Contact contact = contact_of_body(i, touches_[k], values_of(i, number));
    body_touches_.push_back({i, number, touches_[k], contact});
    contact.stiffness *= touches_[k].weight;
    all.contacts.add(contact);
    presses = presses || contact.stiffness > 0.0;
  }
  all.spheres += presses;
}

SharedContacts::Contact FixSurface::contact_of_body(int i, const Touch &touch, const double *history) const {
  const double distance = std::sqrt(touch.distance2), overlap = atom->radius[i] - distance;
  const Vec3 normal = (1.0 / distance) * touch.away;
  const bool touches = laws_.touching(overlap, history);
  const double neck = touches ? laws_.neck_m(atom->radius[i], overlap, history) : 0.0;
  const Triangle &corner = search_.triangle(touch.triangle);
  Vec3 closing = from(atom->v[i]);
  for (int c = 0; c < 3; ++c)
    closing = closing - touch.at.weight[c] * surface_.velocity_half_way(corner[c]);
  return {normal, bodies_->moment_about_centre(i, normal), {0, 0, 0}, 2.0 * law(i, touch).e_star_Pa * neck,
          dot(closing, normal)};
}

// The mass by which the dampers of a contact go.
double FixSurface::damped_kg(const BodyTouch &of) const {
  const double whole_kg = atom->rmass[of.sphere];
  const auto turning = [&](Vec3 moment, Vec3) { return bodies_->turns_per(of.sphere, moment); };
  const BodyTouches &all = of_body_[bodies_->lead_of_atom(of.sphere)];
  if (all.spheres > 1 && of.contact.stiffness > 0.0)
    return all.contacts.mass_kg(of.contact.stiffness, whole_kg, turning);
  return 1.0 / (1.0 / whole_kg + turning(of.contact.turned, {}));
}

template <class Worn>
void FixSurface::push_bodies(Worn &worn) {
  for (const BodyTouch &of : body_touches_) {
    const int i = of.sphere;
    const Given before = {i, from(atom->f[i]), from(atom->torque[i])};
    push(i, of.touch, damped_kg(of), values_of(i, of.number), worn);
    if (last_evaluation_)
      given_.push_back({i, from(atom->f[i]) - before.force_N, from(atom->torque[i]) - before.torque_N_m});
  }
  for (const BodyTouch &of : body_touches_) of_body_[bodies_->lead_of_atom(of.sphere)] = {};
  body_touches_.clear();
}

// A contact that sticks lasts as long as its neck, whose depth counts from where it snaps; the neck
// goes along from triangle to triangle.  All places are matched with what is remembered.
void FixSurface::keep_necks(int i) {
  history_.match(i, touches_);
  size_t kept = 0;
  for (const Touch &touch : touches_) {
    const bool necked = history_.values(i, touch.record)[0] > 0;
    if (touch.depth_m > 0 || (necked && law(i, touch).holds(touch.depth_m))) touches_[kept++] = touch;
  }
  touches_.resize(kept);
  if (kept < 2) return;  // a single contact's depth is compared with no other
  for (Touch &touch : touches_) touch.depth_m -= law(i, touch).separation_m();
}

Jkr FixSurface::law(int i, const Touch &touch) const {
  return laws_.jkr(atom->type[i], type_[touch.triangle], atom->radius[i]);
}

// One contact through LIGGGHTS's own contact model, which takes the particle's mass for its dampers.  What it
// added to the particle is measured, and scaled where contacts share a force; 8/15 E* sqrt(r) overlap^2.5 is Hertz's energy.  Verlet's
// velocities are those of the middle of the step while forces are evaluated: so is the surface's.
//
// The model sees the particle from the triangle, which moves and turns.  What it adds to the particle,
// a force and a couple about its centre, the triangle gets the opposite of: the force at the closest
// point, and by its corners the couple that is left about that point (of resistance to rolling, and as
// LIGGGHTS lets friction act half an overlap below the surface).
template <class Worn>
void FixSurface::push(int i, const Touch &touch, double damped_kg, double *history, Worn &worn) {
  double *force = atom->f[i], *torque = atom->torque[i];
  const Vec3 force_before = from(force), torque_before = from(torque);
  const Triangle &corner = search_.triangle(touch.triangle);
  const double *w = touch.at.weight;
  const TriangleSpin turning(surface_.position(corner[0]), surface_.position(corner[1]),
                             surface_.position(corner[2]));
  const Vec3 corner_m_per_s[3] = {surface_.velocity_half_way(corner[0]),
                              surface_.velocity_half_way(corner[1]),
                              surface_.velocity_half_way(corner[2])};
  const Vec3 spin = turning.spin(corner_m_per_s[0], corner_m_per_s[1], corner_m_per_s[2]);
  Vec3 wall = w[0] * corner_m_per_s[0] + w[1] * corner_m_per_s[1] + w[2] * corner_m_per_s[2] +
              cross(spin, touch.away);

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
  double *particle_spin = atom->omega[i];
  const Vec3 spin_in_world = from(particle_spin);
  put(particle_spin, spin_in_world - spin);
  const double whole_kg = std::exchange(atom->rmass[i], damped_kg);
  impl->compute_force(this, contact, overlap > 0, &wall.x);
  const Vec3 slip = StepEnd::slip_of(contact);
  atom->rmass[i] = whole_kg;
  put(particle_spin, spin_in_world);

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
  const double step = between_steps_ ? 0.0 : update->dt;
  const Vec3 couple = turning.solved(from(torque) - torque_before + cross(touch.away, added));
  const Vec3 on_corners[3] = {-w[0] * added - cross(couple, turning.arm(0)),
                              -w[1] * added - cross(couple, turning.arm(1)),
                              -w[2] * added - cross(couple, turning.arm(2))};
  load_.add(surface_, corner, on_corners, step);
  deepest_.add(overlap, atom->radius[i]);
  if (laws_.touching(overlap, history)) {
    if (!on_deck_.empty() && on_deck_[touch.triangle] && !between_steps_)
      deck_contacts_.touched(bodies_ ? bodies_->lead_of_atom(i) : i);
    if (tangent_wanted_now_) add_tangent(touch, contact, history, unshared, turned);
    worn.after(before, slip, contact, history, corner, w, touch.weight, step);
    if (last_evaluation_)
      energy_.add(laws_.stored(atom->type[i], atom_type_wall_, atom->radius[i], 0.0, overlap, history),
                  touch.weight);
  }
}

// What a contact does to a surface that moves: `added` is its whole force, of which it gives its
// share, `turned` what it gives besides.  A contact that slides has no tangential spring or damper.
void FixSurface::add_tangent(const Touch &touch,
                             const LIGGGHTS::ContactModels::SurfacesIntersectData &contact,
                             const double *history, Vec3 added, Vec3 turned) {
  const Vec3 n = from(contact.en), slip = {contact.vtr1, contact.vtr2, contact.vtr3};
  const double neck = laws_.neck_m(atom->radius[contact.i], contact.deltan, history);
  Vec3 damping = -contact.gamman * contact.vn * n;
  double spring = 0.0, damper = 0.0;
  if (laws_.tangential_spring) {
    const Vec3 stretch = from(history + laws_.spring());
    const Vec3 across = added - dot(added, n) * n + contact.kt * stretch;  // -damper slip, or zero
    const double sticking = contact.gammat * norm(slip);
    if (norm(across) >= 0.5 * sticking) {
      spring = contact.kt;
      damper = contact.gammat;
      damping = damping - damper * slip;
    }
  }
  const double w = touch.weight, normal = 2.0 * law(contact.i, touch).e_star_Pa * neck;
  tangent_.add({contact.i,
                 surface_.footing(search_.triangle(touch.triangle), touch.at.weight),
                 n,
                 w * added,
                 w * (added - damping) + turned,
                 {w * normal, w * spring},
                 {w * contact.gamman, w * damper},
                 contact.cri});
}

// Particles whose centre goes through the surface.  A contact pushes a centre back to the side that
// it is on, so that one that is on the other side came there by contacts too soft or steps too long.
// It is looked for in every step, by the way of the centre against the way of the triangles: who
// goes through an opening, past a free edge or between two panels goes through no triangle.

// No less than the square of how far centre and surface moved against each other in this step; in
// the middle of a step of velocity Verlet its velocity is what it moved by.
double FixSurface::step_length2(int i) const {
  const double surface_m = surface_.farthest_moved_m(update->dt);
  const Vec3 moved_m = update->dt * from(atom->v[i]);
  return 2.0 * (dot(moved_m, moved_m) + surface_m * surface_m);
}

Vec3 FixSurface::place_before(int i) const {
  return from(atom->x[i]) - update->dt * from(atom->v[i]);
}

// A centre that went through a triangle in this step is no farther from it than the step's length;
// so nearly always the distance of the nearest one tells that there is nothing to look for.
void FixSurface::find_crossing(const ContactSearch::Near &near, double nearest2) {
  const int i = near.sphere;
  const double radius = atom->radius[i], step2 = step_length2(i);
  if (between_steps_ || (step2 < nearest2 && step2 < radius * radius)) return;
  if (search_.crossed(surface_, near, place_before(i), from(atom->x[i]))) add_crossing(i);
}

// Who moves farther against the surface in a step than triangles are listed around it is looked for
// everywhere.  After such a step lists are made anew, so that it is enough to look then.
void FixSurface::find_far_crossings() {
  if (between_steps_) return;
  for (int i = 0; i < atom->nlocal; ++i) {
    const double listed_m = atom->radius[i] * neighbor->contactDistanceFactor + neighbor->skin;
    if (step_length2(i) < listed_m * listed_m) continue;
    if (search_.crossed_any(surface_, place_before(i), from(atom->x[i]))) add_crossing(i);
  }
}

void FixSurface::add_crossing(int i) {
  const int tag = bodies_ ? static_cast<int>(bodies_->row_of_atom(i).id) : atom->tag[i];
  const bigint step = update->ntimestep;
  const bool known =
      std::any_of(crossings_.begin(), crossings_.end(),
                  [&](const Crossing &other) { return other.step == step && other.tag == tag; });
  if (!known) crossings_.push_back({tag, step, from(atom->x[i])});
}

}  // namespace flipflow
