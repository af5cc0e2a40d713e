/* The drives of a robot: RobotHardware.efforts of hardware/robot_hardware.py.

   The results are bit-identical to those of Python.  Operations have the same order,
   and the code is compiled without -ffast-math and with -ffp-contract=off.  Units are
   those of the Python attributes. kernel/drives.py mirrors and fills these structures. */
#ifndef TOOL0_DRIVES_H
#define TOOL0_DRIVES_H

enum { DRIVES_OK = 0, DRIVES_EVENT = 1, DRIVES_MASSES = 2, DRIVES_MOBILITY = 3 };

/* A moving body (description/bodies.py, DynamicBody). */
typedef struct DriveBody {
    int parent, is_prismatic, master, joint; /* joint: index in the engine */
    double multiplier, mass;
    double placement[12], center[3], tensor[9], armature;
} DriveBody;

typedef struct DriveSpring {
    int joint, master; /* indices of bodies */
    double multiplier, stiffness, reference;
} DriveSpring;

/* The allowed speeds at a position: limits.py, velocity_window. */
typedef struct DriveWindow {
    int is_soft;
    double velocity, k_position, soft_lower, soft_upper;
} DriveWindow;

/* The limits of a drive (limits.py, DriveBounds). */
typedef struct DriveBounds {
    int joint, limits_effort; /* limits_effort: whether k_velocity limits the effort */
    double effort, velocity, lower, upper, rotor, ease, k_velocity;
    DriveWindow window;
} DriveBounds;

/* Constants that change only with a payload, and are shared by all copies of a robot. */
typedef struct DriveTable {
    int n_joints, n_bodies, n_springs, n_drives, n_compensated, pose_period;
    int steps_per_command; /* number of steps in which a position servo reaches a command */
    double dt, gravity;
    /* integral_rate: of velocity servos */
    double damping_ratio, velocity_bandwidth, integral_rate;
    double stopped, blocked, standstill; /* servos.py */
    const DriveBody *bodies;
    const DriveSpring *springs;
    const DriveBounds *bounds;
    const int *compensated; /* numbers of the joints */
} DriveTable;

/* The limits of a goal on one drive (limits.py, DriveLimits). */
typedef struct DriveGoal {
    int is_limited, is_linear, is_force;
    double grip;  /* force at the pads, or effort of the joint; infinite if unlimited */
    double speed; /* speed of the pads; infinite if unlimited */
    double pad_cos, pad_sin, pad_slope;
} DriveGoal;

enum { SERVO_POSITION, SERVO_VELOCITY };

/* A servo (servos.py, ServoLaw and ServoState). */
typedef struct DriveServo {
    int joint, kind, is_stiff;
    double bandwidth, lower, upper, integral_rate;
    double fastest; /* largest acceleration */
    DriveWindow window;
    double target, integral, speed;
} DriveServo;

/* A governed joint (speed_governor.py, GovernedDrive). */
typedef struct DriveGoverned {
    int joint;
    double speed, fast, effort;
} DriveGoverned;

/* Governor that limits the speeds of joints (speed_governor.py, SpeedGovernor). */
typedef struct DriveGovernor {
    int n_drives, n_free, has_mobility, has_before, sweeps;
    int is_new; /* whether the mobility was computed in this memory */
    double tolerance, largest_turn;
    DriveGoverned *drives; /* (n_drives) */
    /* (n_free), numbers of the free joints, starting with the governed joints */
    int *free;
    double *mobility;      /* (n_free, n_free) */
    double *posture;       /* (n_free), positions for which the mobility was computed */
    double *before;        /* (n_joints), velocity in the last step */
} DriveGovernor;

/* The drives of one robot, or of one copy of a robot. */
typedef struct Drives {
    const DriveTable *table;
    long long steps;
    /* the step for which masses were computed in this memory; -1: no step */
    long long masses_at;
    int has_compensation; /* 0: the compensation must be computed */
    int n_servos, has_masses, n_brakes;
    /* (n_joints), the part of the effort that compensates for gravity */
    double *gravity;
    /* (n_joints), velocity in the last step; NaN: the speed is not limited */
    double *before;
    double *compensation; /* (n_compensated) */
    DriveGoal *goals;     /* (n_joints) */
    DriveServo *servos;   /* (n_servos) */
    double *masses;       /* (n_servos, n_servos) */
    /* (n_brakes), joints with an engaged brake, which have no effort */
    int *brakes;
    int *governed;        /* (n_joints), whether the governor limits the joint's speed */
    DriveGovernor governor;
} Drives;

/* Compute the efforts of the next step; all arrays have shape (n_joints).

   effort: in, the efforts that were applied in the last step; out, the efforts of the
   next step.  The function returns DRIVES_EVENT if a value is not finite.  Python must
   then execute this step, and nothing has been changed.  The function returns
   DRIVES_MASSES or DRIVES_MOBILITY if the masses of the servos or the mobility of the
   governor must be computed (masses.c). */
int drives_efforts(Drives *drives, const double *command, const double *position,
                   const double *velocity, double *effort);

/* Compute the frames of n bodies at `position`, shape (n_joints). */
void drives_frames(const DriveBody *bodies, int n, const double *position,
                   double (*frames)[12]);

/* Compute the largest effort and velocity of a joint at `position` (DriveLimits.at). */
void drives_goal_at(const DriveGoal *goal, double position, double *effort,
                    double *velocity);

#endif
