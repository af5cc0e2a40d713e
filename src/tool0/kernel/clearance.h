/* How near shapes are to each other in a pose, and whether motions keep them apart. */

#ifndef TOOL0_CLEARANCE_H
#define TOOL0_CLEARANCE_H

#include <stdint.h>

#define MOST_MOVING 24 /* joints that a plan can move, from base to tip */

/* The engine's memory, and the pairs of shapes that must stay apart.  The second shape
   of a pair is the larger one, or a plane. */
typedef struct {
    int32_t n_joints;
    int32_t n_pairs;
    int32_t tool;  /* body whose axis stays upright; -1 for none */
    int64_t calls; /* out: distances of shapes that were computed */
    int64_t poses; /* out: poses that were looked at */
    void (*kinematics)(const void *model, void *data);
    double (*distance)(
        const void *model, void *data, int first, int second, double most, double *ends);
    const void *model;
    void *data;
    double *position;         /* of the engine ... */
    const int32_t *addresses; /* (n_joints) in it */
    const double *centres;    /* (n_shapes, 3) */
    const double *rotations;  /* (n_shapes, 3, 3) */
    const double *axes;       /* (n_engine_joints, 3), of the joints in the world ... */
    const double *anchors;    /* ... and points on them [m] */
    const int32_t *axis_rows; /* (n_joints) in both */
    const uint32_t *moved_by; /* (n_shapes), a bit for each joint */
    uint32_t sliding;         /* a bit for each joint that slides */
    uint32_t tilting;         /* a bit for each joint that turns the tool */
    const double *bodies;     /* (n_bodies, 3, 3), rotations */
    const double *radii;      /* (n_shapes), of spheres around the shapes; 0 for planes */
    const double *boxes;      /* (n_shapes, 6), centre and half sizes in their frames */
    const int32_t *first, *second; /* (n_pairs) */
    const double *least;      /* (n_pairs), distances that are kept [m] */
    const double *reach;      /* (n_pairs, n_joints), largest relative motion [m/rad] */
    const double *up;         /* (3), in the world */
    const double *tool_axis;  /* (3), in the body of the tool */
    double tilt;              /* largest angle between both [rad] */
    double slack;             /* [m], by which a motion is looked at ahead */
    /* scratch, (n_pairs): */
    double *rates, *until;
    int32_t *looks, *heap;
    int32_t suspect;          /* the pair that was too near the last time */
} Clearances;

enum { FREE = -1, TILTED = -2 }; /* otherwise the number of a pair */

int32_t clearances_at(Clearances *c, const double *q);
int32_t clearances_between(
    Clearances *c, const double *from, const double *to, double *at);
int clearances_are_kept(Clearances *c, const double *q);
int clearances_connect(Clearances *c, const double *from, const double *to);
int32_t clearances_upright(Clearances *c, double *q);

#endif
