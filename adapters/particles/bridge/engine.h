#pragma once

#include <mpi.h>

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "fix_air.h"
#include "fix_bodies.h"
#include "fix_exits.h"
#include "fix_surface.h"
#include "saved_state.h"

namespace LAMMPS_NS {
class LAMMPS;
}

namespace flipflow {

// Makes the contact models of flipflow known to LIGGGHTS.  Every new instance of LIGGGHTS puts some
// models of its own into the same tables, in the place of ours: to be called after each.  `as_packaged`
// adds to those of the package only `jkr`, which it lacks.
void register_contact_models(bool as_packaged);

// One LIGGGHTS instance in this process.  Every call but the plain readers is collective over
// the communicator.  Errors of LIGGGHTS are std::runtime_error.
class Engine {
 public:
  // `contact_distance_factor`: contacts are remembered while bodies are within this factor of their contact
  // distance.  `class_ratio`: of the largest radii of classes of size (PairLists).  `as_packaged`: with the
  // contact models of the package, in a process whose engines are all so.
  Engine(MPI_Comm communicator, const std::string &screen_file, const std::string &log_file,
         double contact_distance_factor, double class_ratio, bool as_packaged);
  ~Engine();
  Engine(const Engine &) = delete;

  void command(const std::string &line);

  // New particles: each rank takes those whose place it owns; ids count on from `first_id`.
  struct Particles {
    const double *position_m, *velocity_m_per_s, *spin_rad_per_s, *diameter_m, *density_kg_per_m3;
    const int *type;
    int count;
  };
  void create(const Particles &particles, int first_id);

  // New bodies, turned by quaternions, with ids in order from `first_id`; the diameters are sieve sizes.
  void create_bodies(const Particles &particles, const int *shape, const double *turn, int first_id);

  // Which of the places would overlap the surface or one of this rank's particles.
  std::vector<bool> overlaps(const double *position_m, const double *diameter_m, int count);

  // Contact history goes from the neighbour list to the particles: before create.
  void store_history();
  // Takes out who is in an exit, sorts particles, rebuilds neighbour lists and evaluates all forces: after
  // create.
  void prepare();
  void set_step(double step_s);
  void run(int steps);

  // Where the box is cut into the ranks' parts: along x, y and z the fractions of its side, from 0 to
  // 1, at which parts begin and end.
  using Cuts = std::array<std::vector<double>, 3>;
  Cuts cuts() const;
  // Cuts elsewhere, alike on every rank: at once, while there are no particles, or when they are next
  // handed to other ranks, which changes nothing else.  They go to ranks side by side only, so each cut
  // stays between those that are now beside it.
  void cut(const Cuts &cuts);
  void cut_later(const Cuts &cuts);
  // The lowest and the highest corner of the box that is cut, which grows and shrinks with the particles.
  std::array<double, 6> box_m() const;

  // Between runs: what the next ones depend on, and back to there, bit for bit, from anywhere.
  SavedState save();
  void restore(const SavedState &saved);

  LAMMPS_NS::LAMMPS &lammps() { return *lammps_; }
  FixSurface &surface();
  FixExits &exits();
  FixAir *air();  // null: the input has none
  FixBodies *bodies();  // null: all particles are single spheres

  // Before the first particle (see FixBodies).
  void set_shapes(std::vector<BodyShape> shapes, double reach_m);

  void set_laws(const ContactLaws &laws);
  const ContactLaws &laws() const { return laws_; }

 private:
  void list_and_evaluate();

  bool is_mine(const double *place_m) const;

  template <class Call>
  void guarded(Call call);

  LAMMPS_NS::LAMMPS *lammps_ = nullptr;
  ContactLaws laws_;
  Cuts next_cuts_;  // empty: as they are
  bool healthy_ = true;
};

}  // namespace flipflow
