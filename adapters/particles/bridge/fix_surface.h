#pragma once

#include <mpi.h>

#include "contact_interface.h"
#include "fix_wall_gran.h"

#include "smooth_patches.h"
#include "surface_path.h"
#include "triangle_grid.h"

namespace flipflow {

// The triangulated surface that particles touch, as a LIGGGHTS wall.
//
// The stock constructor of fix wall/gran sets up the contact model that the input names; here
// every force evaluation hands it the contacts found on our own surface.  Every rank holds the
// whole surface and serves its own particles.  History stays with the particle: a list of
// records [normal (3), values of the contact model (dnum)], matched by normal, so that a contact
// that wanders from one triangle to the next keeps its tangential spring.
class FixSurface : public LAMMPS_NS::FixWallGran {
 public:
  FixSurface(LAMMPS_NS::LAMMPS *lmp, int narg, char **arg);
  ~FixSurface() override;

  // `type` is the LIGGGHTS atom type of each triangle's material.
  void set_surface(SurfacePath surface, std::vector<Triangle> triangles, std::vector<int> type,
                   double largest_radius_m, bool tangential_spring);

  // The next `steps` steps follow a new path.  A jump from the present places to the path's
  // start does work against the present contact forces.
  void begin_path(const double *start_m, const double *start_m_s, const double *end_m,
                  const double *end_m_s, double length_s, int steps);
  void begin_sums(double step_s);
  void end_sums(double step_s);

  const std::vector<double> &impulse_N_s() const { return impulse_; }  // on each point, last sums
  const std::vector<double> &force_N() const { return last_force_; }   // last evaluation
  double work_J() const { return work_; }             // by the surface on the particles, total
  double elastic_energy_J() const { return elastic_; }  // in surface contacts, last evaluation
  int contacts() const { return contacts_; }          // last evaluation

  int setmask() override;
  void post_create() override {}  // the base class would make a history for its primitive wall
  void pre_delete(bool) override {}
  void setup(int) override;
  void pre_neighbor() override { reordered_ = true; }
  void post_force(int) override;
  void post_force_pgl() override {}

  int min_type() override { return 1; }
  int max_type() override;
  double max_rad(int) override { return largest_radius_; }
  double min_rad(int) override { return 0.0; }

  void grow_arrays(int most) override { records_.resize(most); }
  void copy_arrays(int from, int to, int) override { records_[to] = records_[from]; }
  void set_arrays(int i) override { records_[i].clear(); }
  int pack_exchange(int i, double *buffer) override;
  int unpack_exchange(int i, double *buffer) override;

 private:
  struct Near {  // triangles that particle i may touch before the next search
    int particle, first, end;
  };

  void search();
  void touch(const Near &near);
  void keep_history(int i);
  void push(int i, const Touch &touch, double *history);
  void book(const Touch &touch, Vec3 force_on_particle, Vec3 wall_velocity);

  SurfacePath surface_;
  std::vector<Triangle> triangles_;
  std::vector<int> type_;
  double largest_radius_ = 0.0;
  bool tangential_spring_ = false;

  TriangleGrid grid_;
  double since_grid_ = 0.0, since_search_ = 0.0;  // how far the surface may have moved, m
  bool no_grid_ = true, reordered_ = true;
  std::vector<Near> near_;
  std::vector<int> candidates_;
  std::vector<Touch> touches_;

  int record_size_ = 3;
  std::vector<std::vector<double>> records_;  // per particle
  std::vector<double> old_records_;

  LAMMPS_NS::bigint first_step_ = 0, last_step_ = 0;
  bool last_evaluation_ = false;
  std::vector<double> impulse_, last_force_;
  double work_ = 0.0, last_power_ = 0.0, elastic_ = 0.0;
  int contacts_ = 0;
};

}  // namespace flipflow
