/* Distances between shapes in a pose, and checks of motions for violated distances. */

#ifndef TOOL0_CLEARANCE_H
#define TOOL0_CLEARANCE_H

#include <stdint.h>

#define MOST_MOVING 24 /* largest number of joints that a plan can move, from base to tip */

/* Memory of the engine, and the pairs of shapes that must stay apart.  The second shape
   of a pair is the larger shape, or a plane. */
typedef struct {
    int32_t n_joints;
    int32_t n_pairs;
    int32_t tool;  /* body with an axis that stays upright; -1 for no body */
    int64_t calls; /* out: number of distances of shapes that were computed */
    int64_t poses; /* out: number of poses that were checked */
    void (*kinematics)(const void *model, void *data);
    double (*distance)(
        const void *model, void *data, int first, int second, double most, double *ends);
    const void *model;
    void *data;
    double *position;         /* joint positions of the engine */
    const int32_t *addresses; /* (n_joints), indices in `position` */
    const double *centres;    /* (n_shapes, 3), centers of the shapes */
    const double *rotations;  /* (n_shapes, 3, 3), rotations of the shapes */
    const double *axes;       /* (n_engine_joints, 3), axes of the joints in the world */
    const double *anchors;    /* (n_engine_joints, 3), points on the axes [m] */
    const int32_t *axis_rows; /* (n_joints), rows in `axes` and `anchors` */
    const uint32_t *moved_by; /* (n_shapes), a bit for each joint that moves the shape */
    uint32_t sliding;         /* a bit for each prismatic joint */
    uint32_t tilting;         /* a bit for each joint that rotates the tool */
    const double *bodies;     /* (n_bodies, 3, 3), rotations of the bodies */
    const double *radii;      /* (n_shapes), radii of bounding spheres; 0 for planes */
    /* (n_shapes, 6), centers and half sizes of boxes in the shapes' frames */
    const double *boxes;
    const int32_t *first, *second; /* (n_pairs), numbers of the shapes */
    const double *least;      /* (n_pairs), distances that must be kept [m] */
    const double *reach;      /* (n_pairs, n_joints), largest relative motion [m/rad] */
    const double *up;         /* (3), required direction of the tool's axis in the world */
    const double *tool_axis;  /* (3), axis of the tool in the body's frame */
    double tilt;              /* largest angle between the tool's axis and `up` [rad] */
    /* distance by which the check of a motion advances at least [m] */
    double slack;
    /* Working memory, (n_pairs): */
    double *rates, *until;
    int32_t *looks, *heap;
    int32_t suspect;          /* the pair that was too close in the last violation */
} Clearances;

enum { FREE = -1, TILTED = -2 }; /* other values are the number of a pair */

int32_t clearances_at(Clearances *c, const double *q);
int32_t clearances_between(
    Clearances *c, const double *from, const double *to, double *at);
int clearances_are_kept(Clearances *c, const double *q);
int clearances_connect(Clearances *c, const double *from, const double *to);
int32_t clearances_upright(Clearances *c, double *q);

#endif
