#include "engine.h"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <stdexcept>
#include <utility>

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "fix.h"
#include "input.h"
#include "integrate.h"
#include "lammps.h"
#include "modify.h"
#include "neighbor.h"
#include "pair_lists.h"
#include "rebound.h"
#include "saved_particles.h"
#include "update.h"

namespace flipflow {

using namespace LAMMPS_NS;

namespace {

template <class Style>
Fix *create_fix(LAMMPS *lmp, int narg, char **arg) {
  return new Style(lmp, narg, arg);
}

template <class Style>
Style &find_fix(LAMMPS &lmp, const char *id) {
  const int number = lmp.modify->find_fix(id);
  if (number < 0) throw std::runtime_error(std::string("the input defines no fix named ") + id);
  return static_cast<Style &>(*lmp.modify->fix[number]);
}

// LIGGGHTS's table of fix styles is private and its input can add none from outside.  Naming a
// private member as a template argument of an explicit instantiation is allowed by the language.
using FixStyles = std::map<std::string, Fix *(*)(LAMMPS *, int, char **)>;
FixStyles *Modify::*style_table();
template <FixStyles *Modify::*member>
struct StyleTable {
  friend FixStyles *Modify::*style_table() { return member; }
};
template struct StyleTable<&Modify::fix_map>;

// names in a saved state
const char *const kCuts[3] = {"cuts_x", "cuts_y", "cuts_z"};
const char *const kNextCuts[3] = {"next_cuts_x", "next_cuts_y", "next_cuts_z"};

// LIGGGHTS registers its contact models again for every instance and warns on std::cerr about it.
class QuietErrors {
 public:
  QuietErrors() : buffer_(std::cerr.rdbuf(nullptr)) {}
  ~QuietErrors() { std::cerr.rdbuf(buffer_); }

 private:
  std::streambuf *buffer_;
};

}  // namespace

Engine::Engine(MPI_Comm communicator, const std::string &screen_file,
               const std::string &log_file, double contact_distance_factor, double class_ratio,
               bool as_packaged) {
  std::vector<std::string> words = {"liggghts", "-screen", screen_file, "-log", log_file,
                                    "-nocite"};
  std::vector<char *> arguments;
  for (std::string &word : words) arguments.push_back(word.data());
  const QuietErrors quiet;
  lammps_ = new LAMMPS(static_cast<int>(arguments.size()), arguments.data(), communicator);
  register_contact_models(as_packaged);
  if (!as_packaged) {
    delete lammps_->neighbor;
    lammps_->neighbor = new PairLists(lammps_, class_ratio);
  }
  lammps_->neighbor->register_contact_dist_factor(contact_distance_factor);
  FixStyles &styles = *(lammps_->modify->*style_table());
  styles["wall/gran/flipflow"] = &create_fix<FixSurface>;
  styles["exits/flipflow"] = &create_fix<FixExits>;
  styles["air/flipflow"] = &create_fix<FixAir>;
  styles["bodies/flipflow"] = &create_fix<FixBodies>;
}

// After an error LIGGGHTS's parts may contradict each other: a small leak is better than a crash.
Engine::~Engine() {
  if (!healthy_) return;
  FILE *screen = lammps_->screen;
  deepest_between.erase(lammps_);
  rebounds_of.erase(lammps_);
  bodies_of.erase(lammps_);
  delete lammps_;
  if (screen) std::fclose(screen);
}

template <class Call>
void Engine::guarded(Call call) {
  try {
    call();
  } catch (...) {
    healthy_ = false;
    throw;
  }
}

void Engine::command(const std::string &line) {
  guarded([&] { lammps_->input->one(line.c_str()); });
}

FixSurface &Engine::surface() { return find_fix<FixSurface>(*lammps_, "surface"); }

FixExits &Engine::exits() { return find_fix<FixExits>(*lammps_, "exits"); }

FixAir *Engine::air() {
  return lammps_->modify->find_fix("air") < 0 ? nullptr : &find_fix<FixAir>(*lammps_, "air");
}

// The fix of motion is either LIGGGHTS's own or ours.
FixBodies *Engine::bodies() {
  const int number = lammps_->modify->find_fix("motion");
  return number < 0 ? nullptr : dynamic_cast<FixBodies *>(lammps_->modify->fix[number]);
}

void Engine::set_shapes(std::vector<BodyShape> shapes, double reach_m) {
  FixBodies &bodies = find_fix<FixBodies>(*lammps_, "motion");
  bodies.set_shapes(std::move(shapes), reach_m);
  bodies_of[lammps_] = &bodies;
  static_cast<PairLists *>(lammps_->neighbor)->know(&bodies);
  surface().know(&bodies);
  exits().know(&bodies);
  if (FixAir *air = this->air()) air->know(&bodies);
}

void Engine::set_laws(const ContactLaws &laws) {
  laws_ = laws;
  surface().set_laws(laws);
}

// The box grows with the particles: who is put outside of it belongs to the part at that edge.
bool Engine::is_mine(const double *place_m) const {
  const Domain &domain = *lammps_->domain;
  const Comm &comm = *lammps_->comm;
  for (int d = 0; d < 3; ++d) {
    const bool first = comm.myloc[d] == 0, last = comm.myloc[d] == comm.procgrid[d] - 1;
    if (!first && place_m[d] < domain.sublo[d]) return false;
    if (!last && place_m[d] >= domain.subhi[d]) return false;
  }
  return true;
}

void Engine::create(const Particles &particles, int first_id) {
  Atom &atom = *lammps_->atom;
  for (int k = 0; k < particles.count; ++k) {
    if (!is_mine(particles.position_m + 3 * k)) continue;
    const int i = add_particle(*lammps_, first_id + k, particles.type[k],
                               particles.position_m + 3 * k, 0.5 * particles.diameter_m[k],
                               particles.density_kg_per_m3[k]);
    std::copy_n(particles.velocity_m_per_s + 3 * k, 3, atom.v[i]);
    std::copy_n(particles.spin_rad_per_s + 3 * k, 3, atom.omega[i]);
  }
  atom.natoms += particles.count;
}

void Engine::create_bodies(const Particles &particles, const int *shape, const double *turn,
                           int first_id) {
  FixBodies &bodies = *this->bodies();
  Atom &atom = *lammps_->atom;
  int spheres = 0;
  for (int k = 0; k < particles.count; ++k) {
    const BodyShape &of = bodies.shapes()[shape[k]];
    const int first = bodies.first_tag(first_id + k);
    spheres += static_cast<int>(of.spheres.size());
    if (!is_mine(particles.position_m + 3 * k)) continue;
    FixBodies::Row body = {};
    body.id = first_id + k;
    body.shape = shape[k];
    body.size_m = particles.diameter_m[k];
    body.place = from(particles.position_m + 3 * k);
    body.velocity = from(particles.velocity_m_per_s + 3 * k);
    std::copy_n(turn + 4 * k, 4, body.turn);
    body.momentum =
        bodies.momentum(body, from(particles.spin_rad_per_s + 3 * k), particles.density_kg_per_m3[k]);
    for (int part = 0; part < static_cast<int>(of.spheres.size()); ++part)
      bodies.add(add_particle(*lammps_, first + part, particles.type[k], particles.position_m + 3 * k,
                              body.size_m * of.spheres[part].radius, particles.density_kg_per_m3[k]),
                 body, part);
  }
  atom.natoms += spheres;
}

std::vector<bool> Engine::overlaps(const double *position_m, const double *diameter_m,
                                   int count) {
  std::vector<bool> overlapping(count, false);
  if (count == 0) return overlapping;
  const Atom &atom = *lammps_->atom;
  double largest = 0.5 * *std::max_element(diameter_m, diameter_m + count);
  if (atom.nlocal) largest += *std::max_element(atom.radius, atom.radius + atom.nlocal);
  // the particles between the first and the last place along x and z, by x; along y is the screen's width
  double low[3], high[3];
  for (int d = 0; d < 3; ++d) {
    low[d] = high[d] = position_m[d];
    for (int k = 1; k < count; ++k) {
      low[d] = std::min(low[d], position_m[3 * k + d]);
      high[d] = std::max(high[d], position_m[3 * k + d]);
    }
  }
  const auto between = [&](int i, int d) {
    return atom.x[i][d] > low[d] - largest && atom.x[i][d] < high[d] + largest;
  };
  std::vector<std::pair<double, int>> near;
  for (int i = 0; i < atom.nlocal; ++i)
    if (between(i, 0) && between(i, 2)) near.emplace_back(atom.x[i][0], i);
  std::sort(near.begin(), near.end());
  for (int k = 0; k < count; ++k) {
    const Vec3 x = from(position_m + 3 * k);
    overlapping[k] = surface().reached(x, 0.5 * diameter_m[k]);
    auto particle = std::lower_bound(near.begin(), near.end(), std::make_pair(x.x - largest, 0));
    for (; particle != near.end() && particle->first < x.x + largest && !overlapping[k]; ++particle) {
      const int i = particle->second;
      const double reach = 0.5 * diameter_m[k] + atom.radius[i];
      Vec3 apart = from(atom.x[i]) - x;
      lammps_->domain->minimum_image(apart.x, apart.y, apart.z);
      overlapping[k] = dot(apart, apart) < reach * reach;
    }
  }
  return overlapping;
}

void Engine::store_history() {
  guarded([&] { lammps_->modify->setup_pre_exchange(); });
  if (FixBodies *bodies = this->bodies()) bodies->carry_all();
}

void Engine::prepare() {
  exits().act_at_next_setup();
  list_and_evaluate();
}

void Engine::list_and_evaluate() {
  lammps_->update->whichflag = 1;  // as inside of a run: fixes are asked for their forces, too
  guarded([&] { lammps_->update->integrate->setup_minimal(1); });
  lammps_->update->whichflag = 0;
}

// LIGGGHTS's own arrays of cuts, which its command `balance` would move: the public version has none.
Engine::Cuts Engine::cuts() const {
  const Comm &comm = *lammps_->comm;
  const double *const split[3] = {comm.xsplit, comm.ysplit, comm.zsplit};
  Cuts cuts;
  for (int d = 0; d < 3; ++d) cuts[d].assign(split[d], split[d] + comm.procgrid[d] + 1);
  return cuts;
}

void Engine::cut(const Cuts &cuts) {
  Comm &comm = *lammps_->comm;
  double *const split[3] = {comm.xsplit, comm.ysplit, comm.zsplit};
  for (int d = 0; d < 3; ++d) {
    if (cuts[d].size() != static_cast<size_t>(comm.procgrid[d]) + 1)
      throw std::invalid_argument("the ranks are not as many as the parts that the cuts make");
    std::copy(cuts[d].begin(), cuts[d].end(), split[d]);
  }
  comm.uniform = 0;
  lammps_->domain->set_local_box();
}

void Engine::cut_later(const Cuts &cuts) {
  next_cuts_ = cuts;
  exits().before_exchange([this] {
    if (!next_cuts_[0].empty()) cut(std::exchange(next_cuts_, {}));
  });
}

std::array<double, 6> Engine::box_m() const {
  const Domain &domain = *lammps_->domain;
  std::array<double, 6> corners;
  std::copy_n(domain.boxlo, 3, corners.begin());
  std::copy_n(domain.boxhi, 3, corners.begin() + 3);
  return corners;
}

SavedState Engine::save() {
  SavedState saved;
  const Cuts now = cuts();
  for (int d = 0; d < 3; ++d) {
    saved.reals[kCuts[d]] = now[d];
    saved.reals[kNextCuts[d]] = next_cuts_[d];
  }
  save_particles(*lammps_, saved);
  surface().save(saved);
  if (const FixAir *air = this->air()) air->save(saved);
  if (const FixBodies *bodies = this->bodies()) bodies->save(saved);
  return saved;
}

void Engine::restore(const SavedState &saved) {
  const Cuts then = {saved.real(kCuts[0]), saved.real(kCuts[1]), saved.real(kCuts[2])};
  const bool cut_as_saved = then == cuts();
  if (!is_listed_as_saved(*lammps_, saved) || !cut_as_saved) {
    store_history();  // of who goes: or LIGGGHTS would look for it when it lists those who come
    next_cuts_ = {};
    if (!cut_as_saved) cut(then);
    guarded([&] { place_as_listed(*lammps_, saved); });
    if (FixBodies *bodies = this->bodies()) bodies->place_as_listed(saved);
    list_and_evaluate();
  }
  cut_later({saved.real(kNextCuts[0]), saved.real(kNextCuts[1]), saved.real(kNextCuts[2])});
  guarded([&] {
    go_on_as_saved(*lammps_, saved);
    surface().restore(saved);
    if (FixAir *air = this->air()) air->restore(saved);
    if (FixBodies *bodies = this->bodies()) bodies->restore(saved);
  });
}

void Engine::set_step(double step_s) {
  if (lammps_->update->dt == step_s) return;
  lammps_->update->dt = step_s;
  for (int f = 0; f < lammps_->modify->nfix; ++f) lammps_->modify->fix[f]->reset_dt();
}

void Engine::run(int steps) {
  Update &update = *lammps_->update;
  update.whichflag = 1;
  update.nsteps = steps;
  update.firststep = update.beginstep = update.ntimestep;
  update.laststep = update.endstep = update.ntimestep + steps;
  guarded([&] {
    update.integrate->run(steps);
    update.integrate->cleanup();
  });
  update.whichflag = 0;
}

}  // namespace flipflow
