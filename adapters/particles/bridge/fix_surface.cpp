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

constexpr size_t kMostContacts = 16;  // the deepest count; a sphere has no room for more
constexpr double kSameContact = 0.5;  // cosine between a contact's old and new normal

}  // namespace

FixSurface::FixSurface(LAMMPS *lmp, int narg, char **arg)
    : FixWallGran(lmp, narg, arg), surface_({}) {
  record_size_ = 3 + dnum();
  create_attribute = 1;
  atom->add_callback(0);
  comm->maxexchange_fix += 1 + static_cast<int>(kMostContacts) * record_size_;
  grow_arrays(atom->nmax);
}

FixSurface::~FixSurface() { atom->delete_callback(id, 0); }

int FixSurface::setmask() { return FixConst::PRE_NEIGHBOR | FixConst::POST_FORCE; }

int FixSurface::max_type() { return atom->ntypes; }

void FixSurface::set_surface(SurfacePath surface, std::vector<Triangle> triangles,
                             std::vector<int> type, double largest_radius_m,
                             bool tangential_spring) {
  surface_ = std::move(surface);
  triangles_ = std::move(triangles);
  type_ = std::move(type);
  largest_radius_ = largest_radius_m;
  tangential_spring_ = tangential_spring;
  last_force_.assign(3 * surface_.points(), 0.0);
  impulse_ = last_force_;
  no_grid_ = true;
}

void FixSurface::begin_path(const double *start_m, const double *start_m_s, const double *end_m,
                            const double *end_m_s, double length_s, int steps) {
  double jump2 = 0.0;
  for (int p = 0; p < surface_.points(); ++p) {
    const Vec3 jump = from(&start_m[3 * p]) - surface_.position(p);
    work_ -= dot(from(&last_force_[3 * p]), jump);
    jump2 = std::max(jump2, dot(jump, jump));
  }
  since_grid_ += std::sqrt(jump2);
  since_search_ += std::sqrt(jump2);
  surface_.begin(start_m, start_m_s, end_m, end_m_s, length_s);
  surface_.move(0.0);
  first_step_ = update->ntimestep;
  last_step_ = first_step_ + steps;
}

// Velocity Verlet gives a particle half a step of the force at the interval's start, a whole one
// of each force inside and half a one of that at the end; the sums here do the same.
void FixSurface::begin_sums(double step_s) {
  const double half = 0.5 * step_s;
  for (size_t k = 0; k < impulse_.size(); ++k) {
    impulse_[k] = half * last_force_[k];
    work_ -= half * last_force_[k] * surface_.start_velocity()[k];
  }
}

void FixSurface::end_sums(double step_s) {
  const double half = 0.5 * step_s;
  for (size_t k = 0; k < impulse_.size(); ++k) impulse_[k] -= half * last_force_[k];
  work_ -= half * last_power_;
}

void FixSurface::setup(int flag) {
  reordered_ = true;
  post_force(flag);
}

void FixSurface::post_force(int) {
  computeflag_ = 1;
  shearupdate_ = update->setupflag ? 0 : 1;
  if (!update->setupflag) {
    const double step = static_cast<double>(update->ntimestep - first_step_);
    surface_.move(step / static_cast<double>(last_step_ - first_step_));
    since_grid_ += surface_.fastest_m_s() * update->dt;
    since_search_ += surface_.fastest_m_s() * update->dt;
  }
  if (reordered_ || since_search_ > 0.5 * neighbor->skin) search();
  last_evaluation_ = update->setupflag || update->ntimestep == last_step_;
  if (last_evaluation_) std::fill(last_force_.begin(), last_force_.end(), 0.0);
  elastic_ = last_power_ = 0.0;
  contacts_ = 0;
  for (const Near &near : near_) touch(near);
}

// Candidates stay valid while particle and surface together move less than the margin.  LIGGGHTS
// lets a particle move half a skin from where it was last sorted (so a whole one from where it
// may be now, if it was not sorted just now), we let the surface move another half.
void FixSurface::search() {
  const double skin = neighbor->skin, factor = neighbor->contactDistanceFactor;
  const double margin = reordered_ ? skin : 1.5 * skin;
  if (no_grid_ || since_grid_ > 0.5 * skin) {
    grid_.build(surface_, triangles_, largest_radius_ * factor + 2.0 * skin);
    no_grid_ = false;
    since_grid_ = 0.0;
  }
  near_.clear();
  candidates_.clear();
  for (int i = 0; i < atom->nlocal; ++i) {
    const Vec3 x = from(atom->x[i]);
    const double reach = atom->radius[i] * factor + margin;
    const int first = static_cast<int>(candidates_.size());
    const auto cell = grid_.near(x);
    for (const int *t = cell[0]; t != cell[1]; ++t) {
      const Triangle &corner = triangles_[*t];
      const Vec3 a = surface_.position(corner[0]), b = surface_.position(corner[1]),
                 c = surface_.position(corner[2]);
      const auto at = closest_point(x, a, b, c);
      const Vec3 away = x - (at.weight[0] * a + at.weight[1] * b + at.weight[2] * c);
      if (dot(away, away) < reach * reach) candidates_.push_back(*t);
    }
    const int end = static_cast<int>(candidates_.size());
    if (end > first)
      near_.push_back({i, first, end});
    else
      records_[i].clear();
  }
  reordered_ = false;
  since_search_ = 0.0;
}

void FixSurface::touch(const Near &near) {
  const int i = near.particle;
  const Vec3 x = from(atom->x[i]);
  const double reach = atom->radius[i] * neighbor->contactDistanceFactor;
  touches_.clear();
  for (int k = near.first; k < near.end; ++k) {
    const Triangle &corner = triangles_[candidates_[k]];
    const Vec3 a = surface_.position(corner[0]), b = surface_.position(corner[1]),
               c = surface_.position(corner[2]);
    const auto at = closest_point(x, a, b, c);
    const Vec3 away = x - (at.weight[0] * a + at.weight[1] * b + at.weight[2] * c);
    const double distance2 = dot(away, away);
    if (distance2 < reach * reach && distance2 > 0)
      touches_.push_back({candidates_[k], at, away, distance2, 1.0});
  }
  if (touches_.size() > 1) one_per_smooth_patch(touches_, triangles_);
  if (touches_.size() > kMostContacts) touches_.resize(kMostContacts);
  keep_history(i);
  for (size_t k = 0; k < touches_.size(); ++k) {
    double *record = &records_[i][k * record_size_];
    push(i, touches_[k], dnum() > 0 ? record + 3 : nullptr);
  }
}

// Gives every present contact the record of the old contact with the nearest normal.
void FixSurface::keep_history(int i) {
  std::vector<double> &records = records_[i];
  if (records.empty() && touches_.empty()) return;
  old_records_.swap(records);
  records.assign(touches_.size() * record_size_, 0.0);
  for (size_t k = 0; k < touches_.size(); ++k) {
    const Vec3 normal = (1.0 / std::sqrt(touches_[k].distance2)) * touches_[k].away;
    double nearest = kSameContact;
    double *match = nullptr;
    for (size_t old = 0; old < old_records_.size(); old += record_size_) {
      const double cosine = dot(normal, from(&old_records_[old]));
      if (cosine > nearest) {
        nearest = cosine;
        match = &old_records_[old];
      }
    }
    double *record = &records[k * record_size_];
    if (match) {
      std::copy(match, match + record_size_, record);
      match[0] = match[1] = match[2] = 0.0;  // taken
    }
    record[0] = normal.x;
    record[1] = normal.y;
    record[2] = normal.z;
  }
}

// One contact through LIGGGHTS's own contact model.
void FixSurface::push(int i, const Touch &touch, double *history) {
  double *force = atom->f[i], *torque = atom->torque[i];
  const Vec3 force_before = from(force), torque_before = from(torque);
  const Triangle &corner = triangles_[touch.triangle];
  const double *w = touch.at.weight;
  Vec3 wall = w[0] * surface_.velocity(corner[0]) + w[1] * surface_.velocity(corner[1]) +
              w[2] * surface_.velocity(corner[2]);

  LIGGGHTS::ContactModels::SurfacesIntersectData contact;
  contact.is_wall = true;
  contact.i = i;
  contact.radi = atom->radius[i];
  contact.deltan = atom->radius[i] - std::sqrt(touch.distance2);
  contact.delta[0] = touch.away.x;
  contact.delta[1] = touch.away.y;
  contact.delta[2] = touch.away.z;
  contact.contact_history = history;
  atom_type_wall_ = type_[touch.triangle];
  const double overlap = contact.deltan;
  impl->compute_force(this, contact, overlap > 0, &wall.x);

  Vec3 added = from(force) - force_before;
  if (touch.weight < 1) {
    added = touch.weight * added;
    const Vec3 turned = touch.weight * (from(torque) - torque_before);
    std::fill(force, force + 3, 0.0);
    std::fill(torque, torque + 3, 0.0);
    add_to(force, force_before + added);
    add_to(torque, torque_before + turned);
  }
  book(touch, added, wall);
  if (overlap > 0) {
    ++contacts_;
    // Hertz: integral of 4/3 E* sqrt(R) d^1.5; kn is 4/3 E* sqrt(R d)
    double energy = 0.4 * contact.kn * overlap * overlap;
    if (tangential_spring_) energy += 0.5 * contact.kt * dot(from(history), from(history));
    elastic_ += touch.weight * energy;
  }
}

void FixSurface::book(const Touch &touch, Vec3 force_on_particle, Vec3 wall_velocity) {
  const double dt = update->setupflag ? 0.0 : update->dt;
  const double power = dot(force_on_particle, wall_velocity);
  work_ += dt * power;
  for (int k = 0; k < 3; ++k) {
    const int value = 3 * triangles_[touch.triangle][k];
    const Vec3 share = -touch.at.weight[k] * force_on_particle;
    add_to(&impulse_[value], dt * share);
    if (last_evaluation_) add_to(&last_force_[value], share);
  }
  last_power_ += power;
}

int FixSurface::pack_exchange(int i, double *buffer) {
  buffer[0] = static_cast<double>(records_[i].size());
  std::copy(records_[i].begin(), records_[i].end(), buffer + 1);
  return 1 + static_cast<int>(records_[i].size());
}

int FixSurface::unpack_exchange(int i, double *buffer) {
  const int size = static_cast<int>(buffer[0]);
  records_[i].assign(buffer + 1, buffer + 1 + size);
  return 1 + size;
}

}  // namespace flipflow
