#pragma once

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <type_traits>
#include <utility>
#include <vector>

#include "atom.h"
#include "comm.h"
#include "fix.h"
#include "update.h"

#include "../../vec3.h"
#include "saved_state.h"

namespace flipflow {

// What grains are made of, at a sieve size of 1 and a density of 1 (Shape in orchestrator/ports/grains.py).
struct BodyShape {
  struct Sphere {
    Vec3 place;
    double radius;
  };
  std::vector<Sphere> spheres;
  double volume, bounding_radius;
  double inertia[3], per_inertia[3];

  bool is_ball() const { return spheres.size() == 1; }
  double equivalent_diameter() const { return std::cbrt(6.0 * volume / M_PI); }
};

// Rigid bodies of one or more spheres, each an atom of LIGGGHTS: their motion in place of its nve/sphere, and
// gravity in place of its fix, since every sphere has the mass of its whole body (contacts: shared_contacts.h).
//
// Velocity Verlet.  The angular momentum is kept in the world's axes, where nothing but torques changes it.  A
// free body turns about its principal axes one after the other, z y x y z (A. Dullweber, B. Leimkuhler and
// R. McLachlan, J. Chem. Phys. 107 (1997) 5840-5851, doi 10.1063/1.474310), each time by Cayley's angle,
// 2 atan(t / 2) in place of t: that is of second order, reversible and symplectic, and needs no sines.
//
// Bodies are whole on one rank, that of their centre.  Where LIGGGHTS hands particles to other ranks, moves them
// by a period and chooses who is seen from next door, all spheres of a body are at its centre; before it lists
// neighbours they go to their places.  So ranks must see as much farther as spheres are from centres.
//
// `fix motion all bodies/flipflow <gravity x> <y> <z>`, before the exits.
class FixBodies : public LAMMPS_NS::Fix {
 public:
  // Of a body; alike in the rows of all its spheres are only the first two numbers, the others are with the first.
  struct Row {
    double id, shape, size_m, part;  // part: the number of the sphere in the shape
    Vec3 place, velocity, momentum;  // of the centre of mass; angular, in the world's axes
    double turn[4];                  // quaternion: from the principal axes to the world
    Vec3 listed_place;               // when neighbours were last listed
    double listed_turn[4];
  };
  static constexpr int kRow = sizeof(Row) / sizeof(double);

  FixBodies(LAMMPS_NS::LAMMPS *lmp, int narg, char **arg)
      : Fix(lmp, narg, arg), gravity_{std::atof(arg[3]), std::atof(arg[4]), std::atof(arg[5])} {
    time_integrate = 1;
    comm_forward = kSeen;
    atom->add_callback(0);
    comm->maxexchange_fix += kRow;
    grow_arrays(atom->nmax);
  }
  ~FixBodies() override { atom->delete_callback(id, 0); }

  // `reach_m`: how far from its centre the largest body may have a sphere's centre, and that sphere's radius.
  void set_shapes(std::vector<BodyShape> shapes, double reach_m) {
    shapes_ = std::move(shapes);
    most_ = 1;
    for (const BodyShape &of : shapes_) most_ = std::max(most_, static_cast<int>(of.spheres.size()));
    reach_ = reach_m;
  }
  const std::vector<BodyShape> &shapes() const { return shapes_; }

  int setmask() override {
    using namespace LAMMPS_NS::FixConst;
    return INITIAL_INTEGRATE | FINAL_INTEGRATE | PRE_EXCHANGE | PRE_NEIGHBOR | PRE_FORCE;
  }
  double extend_cut_ghost() override { return 2.0 * reach_; }

  // Of this rank, by number from 0: valid until neighbours are listed anew.
  int count() const { return static_cast<int>(first_.size()) - 1; }
  const Row &row(int body) const { return rows_[lead(body)]; }
  int lead(int body) const { return member_[first_[body]]; }
  std::vector<int> spheres(int body) const {
    return {member_.begin() + first_[body], member_.begin() + first_[body + 1]};
  }
  double mass_kg(int body) const { return atom->rmass[lead(body)]; }
  double bounding_radius_m(int body) const {
    return row(body).size_m * shape(row(body)).bounding_radius;
  }
  double equivalent_diameter_m(int body) const {
    return row(body).size_m * shape(row(body)).equivalent_diameter();
  }
  Vec3 spin(int body) const { return spin_of(row(body)); }
  Vec3 force_N(int body) const { return force_[body]; }  // of the last evaluation
  // Of what acts by now in this one.
  Vec3 force_now_N(int body) const {
    Vec3 force = mass_kg(body) * gravity_;
    for (int m = first_[body]; m < first_[body + 1]; ++m) force = force + from(atom->f[member_[m]]);
    return force;
  }

  // By number of the atom.
  bool is_lead(int i) const { return rows_[i].part == 0.0; }
  const Row &row_of_atom(int i) const { return rows_[i]; }
  int lead_of_atom(int i) const { return lead_[i]; }
  bool same_body(int i, int j) const { return rows_[i].id == rows_[j].id; }
  Vec3 spin_of(const Row &body) const { return spin(body, Axes(body.turn)); }

  // The moment about the centre of its body, in its principal axes, of a force of 1 at sphere i; seen from next
  // door, too.
  Vec3 moment_about_centre(int i, Vec3 force) const {
    const Row &own = rows_[i];
    const BodyShape &of = shape(own);
    if (of.is_ball()) return {0, 0, 0};
    const Vec3 arm_m = own.size_m * of.spheres[static_cast<size_t>(own.part)].place;
    return cross(arm_m, Axes(turn_of_atom(i)).to_own(force));
  }
  // Power of such a moment with the turning velocity that its impulse gives the body of sphere i.
  double turns_per(int i, Vec3 moment) const {
    const BodyShape &of = shape(rows_[i]);
    return (of.per_inertia[0] * moment.x * moment.x + of.per_inertia[1] * moment.y * moment.y +
            of.per_inertia[2] * moment.z * moment.z) *
           per_moment_scale(rows_[i], atom->rmass[i]);
  }

  // The ids of spheres follow from those of their bodies, as many for each as the largest shape needs.
  int first_tag(int body_id) const { return (body_id - 1) * most_ + 1; }
  int body_of_tag(int tag) const { return (tag - 1) / most_ + 1; }

  // Makes atom i the sphere `part` of a body, whose mass it gets; its radius and place follow.
  void add(int i, Row body, int part) {
    const BodyShape &of = shape(body);
    body.part = part;
    rows_[i] = body;
    atom->radius[i] = body.size_m * of.spheres[part].radius;
    atom->rmass[i] = mass_of(body, atom->density[i]);
    const Vec3 arm = Axes(body.turn).to_world(body.size_m * of.spheres[part].place);
    put(atom->x[i], body.place + arm);
  }

  // The angular momentum of a body that spins, at a density.
  Vec3 momentum(const Row &body, Vec3 spin, double density_kg_per_m3) const {
    const BodyShape &of = shape(body);
    const double scale = density_kg_per_m3 * std::pow(body.size_m, 5);
    const Axes axes(body.turn);
    const Vec3 own = axes.to_own(spin);
    return axes.to_world(scale * Vec3{of.inertia[0] * own.x, of.inertia[1] * own.y, of.inertia[2] * own.z});
  }

  // The forces and torques on the spheres, and gravity, on the bodies.
  void gather() {
    for (int b = 0; b < count(); ++b) {
      Vec3 force = mass_kg(b) * gravity_, torque = {0, 0, 0};
      for (int m = first_[b]; m < first_[b + 1]; ++m) {
        const int i = member_[m];
        const Vec3 on_sphere = from(atom->f[i]);
        force = force + on_sphere;
        torque = torque + from(atom->torque[i]) + cross(arm_[m], on_sphere);
      }
      force_[b] = force;
      torque_[b] = torque;
    }
  }

  void setup(int) override { gather(); }

  void initial_integrate(int) override {
    const double step = update->dt, half = 0.5 * step;
    for (int b = 0; b < count(); ++b) {
      Row &body = rows_[lead(b)];
      body.velocity = body.velocity + (half / mass_kg(b)) * force_[b];
      body.momentum = body.momentum + half * torque_[b];
      body.place = body.place + step * body.velocity;
    }
    turn_all(step);
    for (int b = 0; b < count(); ++b) carry(b);
  }

  // Who looks at spheres between two steps of a run looks at their velocities in the middle of the step.
  void final_integrate() override {
    gather();
    const double half = 0.5 * update->dt;
    const bool last = update->ntimestep == update->laststep;
    for (int b = 0; b < count(); ++b) {
      Row &body = rows_[lead(b)];
      body.velocity = body.velocity + (half / mass_kg(b)) * force_[b];
      body.momentum = body.momentum + half * torque_[b];
      if (last) move(b, spin_of(body));
    }
  }

  // All spheres to the centres of their bodies, and back, where the first one may have gone on by a period.
  void pre_exchange() override {
    find_bodies();
    for (int b = 0; b < count(); ++b)
      for (int m = first_[b]; m < first_[b + 1]; ++m) put(atom->x[member_[m]], row(b).place);
  }
  void setup_pre_exchange() override { pre_exchange(); }

  void pre_neighbor() override {
    find_bodies();
    for (int b = 0; b < count(); ++b) {
      Row &body = rows_[lead(b)];
      body.place = body.listed_place = from(atom->x[lead(b)]);
      std::copy_n(body.turn, 4, body.listed_turn);
      carry(b);
    }
    comm->forward_comm();
  }
  void setup_pre_neighbor() override { pre_neighbor(); }

  // Next door they see of a sphere whose it is and how it is turned.
  void pre_force(int) override { comm->forward_comm_fix(this); }
  void setup_pre_force(int flag) override { pre_force(flag); }
  int pack_comm(int n, int *atoms, double *buffer, int, int *) override {
    for (int k = 0; k < n; ++k, buffer += kSeen) {
      std::copy_n(&rows_[atoms[k]].id, kSeen - 4, buffer);
      std::copy_n(turn_of_atom(atoms[k]), 4, buffer + kSeen - 4);
    }
    return kSeen;
  }
  void unpack_comm(int n, int first, double *buffer) override {
    for (int i = first; i < first + n; ++i, buffer += kSeen) {
      std::copy_n(buffer, kSeen - 4, &rows_[i].id);
      std::copy_n(buffer + kSeen - 4, 4, rows_[i].turn);
    }
  }

  // Back to their places, where nobody has gone to another rank.
  void carry_all() {
    for (int b = 0; b < count(); ++b) carry(b);
  }

  void grow_arrays(int most) override { rows_.resize(most); }
  void copy_arrays(int from, int to, int) override { rows_[to] = rows_[from]; }
  int pack_exchange(int i, double *buffer) override {
    const double *row = reinterpret_cast<const double *>(&rows_[i]);
    std::copy_n(row, kRow, buffer);
    return kRow;
  }
  int unpack_exchange(int i, double *buffer) override {
    std::copy_n(buffer, kRow, reinterpret_cast<double *>(&rows_[i]));
    return kRow;
  }

  void save(SavedState &saved) const {
    const double *rows = reinterpret_cast<const double *>(rows_.data());
    saved.reals["bodies"].assign(rows, rows + static_cast<size_t>(kRow) * atom->nlocal);
  }

  // The rows of atoms as they come, each at the place and attitude in which it was last listed.
  void place_as_listed(const SavedState &saved) {
    load(saved);
    for (int i = 0; i < atom->nlocal; ++i) {
      Row body = rows_[i];
      body.place = body.listed_place;
      std::copy_n(body.listed_turn, 4, body.turn);
      rows_[i] = body;
      atom->rmass[i] = mass_of(body, atom->density[i]);
    }
  }
  // After the particles.
  void restore(const SavedState &saved) {
    load(saved);
    find_bodies();
    for (int b = 0; b < count(); ++b) find_arms(b, Axes(rows_[lead(b)].turn));
    gather();
  }

 private:
  static_assert(sizeof(Row) % sizeof(double) == 0, "rows are packed as numbers");
  static constexpr int kSeen = 8;  // numbers: id, shape, size, part, and four of the turn

  // The rotation of a unit quaternion: rows of its matrix.
  struct Axes {
    Vec3 row[3];
    explicit Axes(const double *q) {
      const double w = q[0], x = q[1], y = q[2], z = q[3];
      row[0] = {1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)};
      row[1] = {2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)};
      row[2] = {2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)};
    }
    Vec3 to_world(Vec3 own) const { return {dot(row[0], own), dot(row[1], own), dot(row[2], own)}; }
    Vec3 to_own(Vec3 world) const { return world.x * row[0] + world.y * row[1] + world.z * row[2]; }
  };

  const double *turn_of_atom(int i) const { return rows_[i < atom->nlocal ? lead_[i] : i].turn; }
  const BodyShape &shape(const Row &body) const { return shapes_[static_cast<size_t>(body.shape)]; }
  double mass_of(const Row &body, double density_kg_per_m3) const {
    return density_kg_per_m3 * shape(body).volume * (body.size_m * body.size_m * body.size_m);
  }

  // By what the inverse moments at a density and a size of 1 are multiplied.
  double per_moment_scale(const Row &body, double mass_kg) const {
    return shape(body).volume / (mass_kg * (body.size_m * body.size_m));
  }

  Vec3 spin(const Row &body, const Axes &axes) const {
    const int i = static_cast<int>(&body - rows_.data());
    const double per_scale = per_moment_scale(body, atom->rmass[i]);
    const BodyShape &of = shape(body);
    const Vec3 own = per_scale * axes.to_own(body.momentum);
    return axes.to_world({of.per_inertia[0] * own.x, of.per_inertia[1] * own.y, of.per_inertia[2] * own.z});
  }

  // Torque-free turning over a step.  It is a chain of operations that wait for each other, so that four bodies
  // take hardly longer than one: they go together where they turn little, to the same bits.
  using Lanes = double __attribute__((vector_size(32)));
  static constexpr int kLanes = sizeof(Lanes) / sizeof(double);

  void turn_all(double step) {
    for (int b = 0; b < count(); b += kLanes) {
      const int some = std::min(kLanes, count() - b);
      Lanes own[3], q[4], per[3];
      bool little = true;
      for (int n = 0; n < kLanes; ++n) {
        const Turning one = turning(rows_[lead(b + std::min(n, some - 1))], step);
        for (int k = 0; k < 3; ++k) own[k][n] = one.own[k];
        for (int k = 0; k < 3; ++k) per[k][n] = one.per[k];
        for (int k = 0; k < 4; ++k) q[k][n] = one.q[k];
        little = little && one.is_little();
      }
      if (little) turn(own, q, per);
      for (int n = 0; n < some; ++n) {
        Row &body = rows_[lead(b + n)];
        if (shape(body).is_ball()) continue;
        if (!little) turn_alone(body, step);
        for (int k = 0; k < 4 && little; ++k) body.turn[k] = q[k][n];
      }
    }
  }

  struct Turning {
    double own[3], q[4], per[3];  // angular momentum in its own axes; half a step over the moments

    // A bound for the squared tangents of half angles: the last moment is the least.
    bool is_little() const {
      return per[2] * per[2] * (own[0] * own[0] + own[1] * own[1] + own[2] * own[2]) < kLittle / 4.0;
    }
  };

  Turning turning(const Row &body, double step) const {
    const int i = static_cast<int>(&body - rows_.data());
    const BodyShape &of = shape(body);
    const double per = 0.5 * step * per_moment_scale(body, atom->rmass[i]);
    const Vec3 own = Axes(body.turn).to_own(body.momentum);
    return {{own.x, own.y, own.z},
            {body.turn[0], body.turn[1], body.turn[2], body.turn[3]},
            {per * of.per_inertia[0], per * of.per_inertia[1], per * of.per_inertia[2]}};
  }

  void turn_alone(Row &body, double step) const {
    Turning one = turning(body, step);
    turn(one.own, one.q, one.per);
    std::copy_n(one.q, 4, body.turn);
  }

  template <class Number>
  static void turn(Number *own, Number *q, const Number *per) {
    const auto about = [&](int k, double share) {  // axis k; the others follow in a circle
      const int l = (k + 1) % 3, m = (k + 2) % 3;
      const Number h = share * per[k] * own[k];  // tangent of half the angle
      Number unit = h * h;
      invert_1_and(unit);
      const Number cosine = (1.0 - h * h) * unit, sine = 2.0 * h * unit;
      const Number a = own[l], b = own[m];
      own[l] = cosine * a + sine * b;
      own[m] = cosine * b - sine * a;
      const Number w = q[0], x = q[1 + k], y = q[1 + l], z = q[1 + m];
      q[0] = w - h * x;
      q[1 + k] = x + h * w;
      q[1 + l] = y + h * z;
      q[1 + m] = z - h * y;
    };
    about(2, 0.5);
    about(1, 0.5);
    about(0, 1.0);
    about(1, 0.5);
    about(2, 0.5);
    Number size = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] - 1.0;
    invert_root_of_1_and(size);
    for (int k = 0; k < 4; ++k) q[k] = size * q[k];
  }

  // x to 1 / (1 + x) and 1 / sqrt(1 + x): without divisions and roots, to rounding, where it is little.
  template <class Number>
  static void invert_1_and(Number &x) {
    if constexpr (std::is_same_v<Number, double>)
      if (!(x < kLittle)) {
        x = 1.0 / (1.0 + x);
        return;
      }
    x = (1.0 - x) * (1.0 + x * x);
  }
  template <class Number>
  static void invert_root_of_1_and(Number &x) {
    if constexpr (std::is_same_v<Number, double>)
      if (!(x < kLittle)) {
        x = 1.0 / std::sqrt(1.0 + x);
        return;
      }
    x = 1.0 - x * (0.5 - x * (0.375 - x * 0.3125));
  }
  static constexpr double kLittle = 1e-5;  // of which not even five make the fourth power more than rounding

  // The spheres to where their body is now.
  void carry(int b) {
    const Row &body = rows_[lead(b)];
    const Axes axes(body.turn);
    find_arms(b, axes);
    for (int m = first_[b]; m < first_[b + 1]; ++m) put(atom->x[member_[m]], body.place + arm_[m]);
    move(b, spin(body, axes));
  }

  void find_arms(int b, const Axes &axes) {
    const Row &body = rows_[lead(b)];
    const BodyShape &of = shape(body);
    for (int m = first_[b]; m < first_[b + 1]; ++m)
      arm_[m] = axes.to_world(body.size_m * of.spheres[m - first_[b]].place);
  }

  void move(int b, Vec3 spin) {
    const Vec3 velocity = rows_[lead(b)].velocity;
    for (int m = first_[b]; m < first_[b + 1]; ++m) {
      const int i = member_[m];
      put(atom->v[i], velocity + cross(spin, arm_[m]));
      put(atom->omega[i], spin);
    }
  }

  void load(const SavedState &saved) {
    const auto &rows = saved.real("bodies");
    std::copy(rows.begin(), rows.end(), reinterpret_cast<double *>(rows_.data()));
  }

  // Which atoms are whose spheres, body by body in the order of their leads in memory.
  void find_bodies() {
    const int n = atom->nlocal;
    std::vector<std::pair<double, int>> leads;
    for (int i = 0; i < n; ++i)
      if (is_lead(i)) leads.emplace_back(rows_[i].id, i);
    std::sort(leads.begin(), leads.end());
    const auto lead_with = [&](double body_id) {
      return std::lower_bound(leads.begin(), leads.end(), std::make_pair(body_id, -1))->second;
    };
    lead_.resize(n);
    std::vector<int> number(n, -1);
    first_.assign(1, 0);
    for (int i = 0; i < n; ++i) {
      lead_[i] = lead_with(rows_[i].id);
      if (!is_lead(i)) continue;
      number[i] = static_cast<int>(first_.size()) - 1;
      first_.push_back(first_.back() + static_cast<int>(shape(rows_[i]).spheres.size()));
    }
    member_.resize(n);
    arm_.resize(n);
    for (int i = 0; i < n; ++i) member_[first_[number[lead_[i]]] + static_cast<int>(rows_[i].part)] = i;
    force_.resize(count());
    torque_.resize(count());
  }

  Vec3 gravity_;
  std::vector<BodyShape> shapes_;
  int most_ = 1;  // spheres of a shape
  double reach_ = 0.0;
  std::vector<Row> rows_;                // of all atoms
  std::vector<int> lead_;                // of each atom: the first sphere of its body
  std::vector<int> first_ = {0}, member_;  // of each body: its atoms, in the order of the shape's spheres
  std::vector<Vec3> arm_;                // from the centre to each of them
  std::vector<Vec3> force_, torque_;     // on each body, gravity included; last evaluation
};

}  // namespace flipflow
