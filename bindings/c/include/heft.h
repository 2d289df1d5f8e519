/* heft: mass properties of construction machines, estimated while they work.
 *
 * The caller gives the memory, then one row after the other:
 *
 *     static uint64_t memory[HEFT_SIZE_MAX / 8];
 *     heft_excavator_init(memory, sizeof memory, NULL, HEFT_EXCAVATOR_METHOD_AUTO,
 *                         HEFT_EXCAVATOR_COLUMN_SWING_VELOCITY);
 *     heft_excavator_step(memory, &sample, &estimate);
 *
 * Units are SI. A sample that is missing is NAN (do not compile the caller with -ffast-math). A row
 * without one of its signals, or with an impossible one, is answered all the same; no number of an
 * estimate is ever NAN or infinite. A quantity that the method does not estimate is 0 without its
 * bit in `estimated`. Believe an estimate where its TRUSTED flag is set; its interval of 95 % is the
 * value +- 1.96 standard deviations.
 *
 * A method of a loader other than full-ekf may be left out of the library (feature every-method).
 *
 * No function allocates, blocks, opens a file or reads a clock. One memory belongs to one thread at
 * a time; different memories are independent. Nothing has to be freed.
 *
 * Written by `cargo run -p heft_c --example header`; do not edit.
 */
#ifndef HEFT_H
#define HEFT_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Version of this header; HEFT_VERSION_NUMBER is 10000 major + 100 minor + patch. */
#define HEFT_VERSION "0.3.0"
#define HEFT_VERSION_NUMBER 300

/* Version of the library that the program runs with. */
const char *heft_version(void);

/* What a program compiles in: structures, bits, methods. A library of another header answers `init` with
 * HEFT_OTHER_HEADER. */
#define HEFT_ABI 0x047d00eau

/* HEFT_ABI of the header that belongs to the library. */
uint32_t heft_abi(void);

/* What a function returns. */
#define HEFT_OK (0) /* done */
#define HEFT_NULL (-1) /* a pointer is null */
#define HEFT_MEMORY (-2) /* the memory is too small, or not aligned to 8 bytes */
#define HEFT_REFUSED (-3) /* a setting, the method or the columns cannot be used; the error text tells which */
#define HEFT_NOT_INITIALISED (-4) /* the memory holds no estimator of this machine */
#define HEFT_NO_SUCH_KEY (-5) /* no key has this name */
#define HEFT_INTERNAL (-6) /* a mistake of the library, told on standard error; initialise the memory anew. Without an operating system it stops instead */
#define HEFT_OTHER_HEADER (-7) /* the program was compiled with the header of another library: take both from one */

/* Enough memory for either machine on every platform; heft_..._size() tells the exact size. */
#define HEFT_SIZE_MAX 34816

/* ---- excavator ---- */

/* Methods. */
#define HEFT_EXCAVATOR_METHOD_AUTO 0
#define HEFT_EXCAVATOR_METHOD_MULTI_FORGETTING_RLS 1
#define HEFT_EXCAVATOR_METHOD_SVF_RLS 2
#define HEFT_EXCAVATOR_METHOD_POSTURE_TORQUE 3
#define HEFT_EXCAVATOR_METHOD_TORQUE 4
#define HEFT_EXCAVATOR_METHOD_POSTURE 5
#define HEFT_EXCAVATOR_METHOD_VELOCITY 6

/* Reasons: why an estimate is not trusted, or what the machine does beside its description. */
#define HEFT_EXCAVATOR_REASON_NONE 0 /* nothing to say */
#define HEFT_EXCAVATOR_REASON_SLOPE 1 /* the ground seems inclined */
#define HEFT_EXCAVATOR_REASON_LOSSES 2 /* the swing drive seems to lose torque */
#define HEFT_EXCAVATOR_REASON_FRICTION 3 /* the friction differs from that of the machine file */
#define HEFT_EXCAVATOR_REASON_GAIN 4 /* the torque reads too high or too low by a factor */
#define HEFT_EXCAVATOR_REASON_DELAY 5 /* velocity and torque do not arrive together */
#define HEFT_EXCAVATOR_REASON_OFFSET 6 /* the torque seems to have an offset */
#define HEFT_EXCAVATOR_REASON_DAMPING 7 /* the damping differs from that of the machine file */
#define HEFT_EXCAVATOR_REASON_UNEXPLAINED 8 /* the motion does not follow the model */
#define HEFT_EXCAVATOR_REASON_DISAGREEMENT 9 /* swings disagree by more than they claim */
#define HEFT_EXCAVATOR_REASON_LIMIT 10 /* the estimate is at the end of its range */
#define HEFT_EXCAVATOR_REASON_CONTENT 11 /* the bucket's content may have changed */
#define HEFT_EXCAVATOR_REASON_FROZEN 12 /* a sensor repeats one value */
#define HEFT_EXCAVATOR_REASON_SIGN 13 /* a sensor seems to have the other sign */
#define HEFT_EXCAVATOR_REASON_METHOD 14 /* this method cannot determine the inertia of an uncalibrated machine */
#define HEFT_EXCAVATOR_REASON_RESTARTED 15 /* the service was started again */
#define HEFT_EXCAVATOR_REASON_JUMP 16 /* a joint angle has jumped further than a joint moves */
#define HEFT_EXCAVATOR_REASON_CONTRADICTION 17 /* an emptied bucket or the friction contradicts what a sensor says */
#define HEFT_EXCAVATOR_REASON_HANGING 18 /* the load hangs or swings */
#define HEFT_EXCAVATOR_REASON_ATTACHMENT 19 /* the bucket's mass differs from that of the machine file */

/* Name of a reason; empty for none. */
static inline const char *heft_excavator_reason(uint32_t code) {
  switch (code) {
    case 0: return "";
    case 1: return "slope";
    case 2: return "losses";
    case 3: return "friction";
    case 4: return "gain";
    case 5: return "delay";
    case 6: return "offset";
    case 7: return "damping";
    case 8: return "unexplained";
    case 9: return "disagreement";
    case 10: return "limit";
    case 11: return "content";
    case 12: return "frozen";
    case 13: return "sign";
    case 14: return "method";
    case 15: return "restarted";
    case 16: return "jump";
    case 17: return "contradiction";
    case 18: return "hanging";
    case 19: return "attachment";
    default: return "unknown";
  }
}

/* Sensors that the machine has, for `columns` of heft_excavator_init; each needs its bit to be used. */
#define HEFT_EXCAVATOR_COLUMN_SWING_VELOCITY (1u << 0)
#define HEFT_EXCAVATOR_COLUMN_SWING_ANGLE (1u << 1)
#define HEFT_EXCAVATOR_COLUMN_SWING_TORQUE (1u << 2)
#define HEFT_EXCAVATOR_COLUMN_BOOM_ANGLE (1u << 3)
#define HEFT_EXCAVATOR_COLUMN_ARM_ANGLE (1u << 4)
#define HEFT_EXCAVATOR_COLUMN_BUCKET_ANGLE (1u << 5)
#define HEFT_EXCAVATOR_COLUMN_PITCH (1u << 6)
#define HEFT_EXCAVATOR_COLUMN_ROLL (1u << 7)
#define HEFT_EXCAVATOR_COLUMN_BOOM_HEAD_PRESSURE (1u << 8)
#define HEFT_EXCAVATOR_COLUMN_BOOM_ROD_PRESSURE (1u << 9)
#define HEFT_EXCAVATOR_COLUMN_ARM_HEAD_PRESSURE (1u << 10)
#define HEFT_EXCAVATOR_COLUMN_ARM_ROD_PRESSURE (1u << 11)
#define HEFT_EXCAVATOR_COLUMN_TRUCK (1u << 12)

/* Bits of `flags` of an estimate. */
#define HEFT_EXCAVATOR_FLAG_EXCITED (1u << 0)
#define HEFT_EXCAVATOR_FLAG_CONSISTENT (1u << 1)
#define HEFT_EXCAVATOR_FLAG_FRESH (1u << 2)
#define HEFT_EXCAVATOR_FLAG_CONVERGED (1u << 3)
#define HEFT_EXCAVATOR_FLAG_IDENTIFIABLE (1u << 4)
#define HEFT_EXCAVATOR_FLAG_HELD (1u << 5)
#define HEFT_EXCAVATOR_FLAG_CHANGING (1u << 6)
#define HEFT_EXCAVATOR_FLAG_RESET (1u << 7)
#define HEFT_EXCAVATOR_FLAG_TRUSTED (1u << 8)
#define HEFT_EXCAVATOR_FLAG_NOMINAL (1u << 9)
#define HEFT_EXCAVATOR_FLAG_WINDOW (1u << 10)
#define HEFT_EXCAVATOR_FLAG_REFUSED (1u << 11)
#define HEFT_EXCAVATOR_FLAG_RESTARTED (1u << 12)

/* Bits of `estimated` of an estimate: which quantities the method has an opinion on. */
#define HEFT_EXCAVATOR_ESTIMATED_DAMPING (1u << 0)
#define HEFT_EXCAVATOR_ESTIMATED_TORQUE (1u << 1)
#define HEFT_EXCAVATOR_ESTIMATED_PAYLOAD (1u << 2)
#define HEFT_EXCAVATOR_ESTIMATED_FRICTION (1u << 3)
#define HEFT_EXCAVATOR_ESTIMATED_OFFSET (1u << 4)
#define HEFT_EXCAVATOR_ESTIMATED_INERTIA (1u << 5)
#define HEFT_EXCAVATOR_ESTIMATED_ACCELERATION (1u << 6)

/* A row of sensors; NAN where a sample is missing. */
typedef struct {
  double t; /* Time of the measurement, by the clock of the data. [s] */
  double swing_velocity; /* Swing rate, positive anticlockwise from above. [rad/s] */
  double swing_angle; /* Swing angle, same sign. [rad] */
  double swing_torque; /* Swing torque at the upper body, positive in the direction of positive motion. [N m] */
  double boom_angle; /* Boom angle to the horizontal, up positive. [rad] */
  double arm_angle; /* Arm angle relative to the boom. [rad] */
  double bucket_angle; /* Bucket angle relative to the arm. [rad] */
  double pitch; /* Pitch of the upper body, nose up positive. [rad] */
  double roll; /* Roll of the upper body, left side low positive. [rad] */
  double boom_head_pressure; /* Pressure at the head side of the boom cylinders, their mean. [Pa] */
  double boom_rod_pressure; /* Pressure at the rod side of the boom cylinders, their mean. [Pa] */
  double arm_head_pressure; /* Pressure at the head side of the arm cylinder. [Pa] */
  double arm_rod_pressure; /* Pressure at the rod side of the arm cylinder. [Pa] */
  double truck; /* Number of the truck that is loaded; another number begins the next truck. */
} heft_excavator_sample;

/* The answer to a row. */
typedef struct {
  double t; /* Time of the measurement, by the clock of the data. [s] */
  double inertia; /* Swing inertia. [kg m^2] */
  double inertia_std; /* Standard deviation of `inertia`, as reported. [kg m^2] */
  double damping; /* Viscous damping. [N m s/rad] */
  double damping_std; /* Standard deviation of `damping`, as reported. [N m s/rad] */
  double torque; /* Torque. [N m] */
  double torque_std; /* Standard deviation of `torque`, as reported. [N m] */
  double payload; /* Payload. [kg] */
  double payload_std; /* Standard deviation of `payload`, as reported. [kg] */
  double velocity; /* Swing velocity. [rad/s] */
  double acceleration; /* Swing acceleration. [rad/s^2] */
  double friction; /* Coulomb friction torque. [N m] */
  double friction_std; /* Standard deviation of `friction`, as reported. [N m] */
  double offset; /* Torque offset. [N m] */
  double offset_std; /* Standard deviation of `offset`, as reported. [N m] */
  double nis; /* Normalised innovation squared of this sample, 0 where none was accepted. */
  double forgetting_inertia; /* Forgetting factor of the inertia (regressions; else 0). */
  double forgetting_damping; /* Forgetting factor of the damping. */
  double forgetting_torque; /* Forgetting factor of the torque. */
  uint64_t refused; /* Rows refused so far. */
  uint32_t flags; /* HEFT_EXCAVATOR_FLAG_... */
  uint32_t estimated; /* HEFT_EXCAVATOR_ESTIMATED_... */
  uint32_t method; /* HEFT_EXCAVATOR_METHOD_..., the one at work. */
  uint32_t reason; /* HEFT_EXCAVATOR_REASON_...: why it is not trusted, or what the machine does beside its description; 0 for none. */
} heft_excavator_estimate;

/* Settings, as in a description; flags are 0 or 1, choices count from 0, NAN is "none" and ends a list. */
typedef struct {
  struct {
    double operating_mass; /* Operating mass; with it all that is not stated has the value that machines of this mass have, with their spread. [kg] */
    double rated_payload; /* Rated payload of the bucket; "none" takes that of machines of the operating mass. [kg] */
    double swing_torque; /* Largest torque of the swing; "none" takes that of machines of the operating mass. [N m] */
    double nominal_damping; /* Viscous damping of the swing, as known beforehand (b-bar). [N m s/rad] */
    double coulomb_friction; /* Coulomb friction torque of the swing. [N m] */
    double coulomb_friction_std; /* Standard deviation of the Coulomb friction; "none" takes prior.friction_std. [N m] */
    double drive_efficiency; /* Efficiency of the swing drive: driving torque arrives times it, braking torque divided by it. */
    double drive_efficiency_std; /* Its standard deviation. */
    double upper_first_moment; /* First moment of the upper body without boom, arm and bucket about the swing axis, forward positive (a counterweight makes it negative); "none" takes 1.15 times what balances the folded, empty attachment, as machines have. [kg m] */
    double upper_first_moment_std; /* Its standard deviation; "none" takes 3 % of a stated moment, a third of one that is not. [kg m] */
    double slope_std; /* Standard deviation of the slope of the ground along each of two axes. [rad] */
    double mass_tolerance; /* Relative standard deviation of the described masses and inertias of boom and arm. */
    double upper_tolerance; /* The same of the upper body's inertia: counterweight, tank, options; "none" takes 7 times mass_tolerance (0.126). */
    double bucket_tolerance; /* The same of the bucket's mass: attachments are changed; "none" takes 11 times mass_tolerance (0.2). */
    double links_gain_correlation; /* Correlation of the errors of the masses of boom and arm with that of sensors.swing_torque_gain, where `heft calibrate` has found them together; "none": nobody has, and what the lengths do to the inertia comes on top of mass_tolerance. */
    double upper_gain_correlation; /* The same of the upper body's inertia with that gain. */
    double upper_links_correlation; /* The same of the upper body's inertia with the masses of boom and arm. */
    double bucket_gain_correlation; /* Correlation of the error of the bucket's mass with that of sensors.swing_torque_gain; "none": the calibration scaled the bucket by the factor of boom and arm. */
    double upper_bucket_correlation; /* The same of the upper body's inertia with the bucket's mass. */
    double links_bucket_correlation; /* The same of the masses of boom and arm with the bucket's mass. */
    double geometry_tolerance; /* Relative standard deviation of the described lengths. */
    double upper_inertia; /* Inertia of the upper body without boom, arm and bucket, about the swing axis (J_u). [kg m^2] */
    double inertia_min; /* Smallest inertia that an estimate may take. [kg m^2] */
    double inertia_max; /* Largest inertia that an estimate may take. [kg m^2] */
  } machine;
  struct {
    double boom_pin; /* Swing axis to boom pin, horizontal (x0). [m] */
    double boom_length; /* Boom pin to arm pin (L1). [m] */
    double arm_length; /* Arm pin to bucket pin (L2). [m] */
    double boom_centre; /* Boom pin to the boom's centre of mass (c1). [m] */
    double arm_centre; /* Arm pin to the arm's centre of mass (c2). [m] */
    double bucket_centre; /* Bucket pin to the bucket's centre of mass (c3). [m] */
    double payload_centre; /* Bucket pin to the payload's centre of mass (cp). [m] */
    double payload_centre_std; /* Standard deviation of that centre, along the bucket and across; "none" takes 5 % of payload_centre in `heft calibrate`, and the spread among machines where payload_centre is guessed. [m] */
    double boom_rise; /* Height of the boom's centre of mass above the line of its pins: goosenecks have some .085 of its length (n1). [m] */
    double bucket_rise; /* The bucket's centre of mass beside the line from its pin to its tip, on the side of its back (n3). [m] */
    double payload_rise; /* The same of the payload's (np). [m] */
    double payload_gyration; /* Radius of gyration of the payload (kp). [m] */
    double boom_mass; /* Mass of the boom (m1). [kg] */
    double arm_mass; /* Mass of the arm (m2). [kg] */
    double bucket_mass; /* Mass of the empty bucket (m3). [kg] */
    double boom_inertia; /* Inertia of the boom across its length, at its centre of mass (I1). [kg m^2] */
    double arm_inertia; /* Inertia of the arm across its length (I2). [kg m^2] */
    double bucket_inertia; /* Inertia of the bucket across its length (I3). [kg m^2] */
    double boom_axial_inertia; /* Inertia of the boom about its length (Ir1). [kg m^2] */
    double arm_axial_inertia; /* Inertia of the arm about its length (Ir2). [kg m^2] */
    double bucket_axial_inertia; /* Inertia of the bucket about its length (Ir3). [kg m^2] */
  } geometry;
  struct {
    double count; /* Number of cylinders side by side. */
    double head_area; /* Area of the piston; 0 says that nothing is known of the cylinder, and leaves its pressures out. [m^2] */
    double head_area_std; /* Its standard deviation; "none" takes 0.5 %. [m^2] */
    double rod_area; /* Area of the piston less that of the rod. [m^2] */
    double base_distance; /* Cylinder base to boom foot (a). [m] */
    double base_distance_std; /* Its standard deviation; "none" takes 0.4 %. [m] */
    double rod_distance; /* Boom foot to rod eye (c). [m] */
    double rod_distance_std; /* Its standard deviation; "none" takes 0.4 %. [m] */
    double angle; /* Angle between the two at boom angle 0 (delta). [rad] */
    double angle_std; /* Its standard deviation. [rad] */
    double friction; /* Friction of the seals, as a share of all pistons at 20 MPa. */
    double friction_std; /* Its standard deviation. */
    double friction_kept; /* Share of it that is left when the cylinder stops: all of it where it stops at once, none where it bounces. */
    double friction_kept_std; /* Its standard deviation. */
    double force_offset; /* Force that the pressures show too much, by the zeros of their sensors. [N] */
    double force_offset_std; /* Its standard deviation; "none" takes that of the sensors' zeros. [N] */
    double span_std; /* Relative standard deviation of the moment; "none" takes those of areas, distances and angle. */
    double span_offset_correlation; /* Correlation of the errors of force offset and span. */
    double boom_cos; /* Moment about the boom foot that the drawing misses: with the cosine of the boom's angle to the horizontal. [N m] */
    double boom_sin; /* With its sine. [N m] */
    double arm_cos; /* With the cosine of the arm's angle to the horizontal. [N m] */
    double arm_sin; /* With its sine. [N m] */
    double bucket_cos; /* With the cosine of the bucket's angle to the horizontal. [N m] */
    double bucket_sin; /* With its sine. [N m] */
  } boom_cylinder;
  struct {
    double rate; /* Samples per second. [Hz] */
    double swing_velocity_std; /* Noise of the swing velocity (sigma_w). [rad/s] */
    double swing_angle_std; /* Noise of the swing angle, where an encoder serves in place of the velocity. [rad] */
    double swing_torque_std; /* Noise of the swing torque (sigma_T). [N m] */
    double swing_torque_gain_std; /* Standard deviation of the torque's gain about 1; "none" takes 0.05, or 0.03 where the boom's pressures weigh too. Nobody knows a gain exactly: 0 says that nothing is known of it and takes 0.05, but is meant with the variant "known", whose "none" is 0. */
    double swing_torque_delay; /* How late the torque comes. [s] */
    double swing_torque_delay_std; /* Its standard deviation. [s] */
    double swing_velocity_delay; /* How late the swing velocity comes. [s] */
    double swing_velocity_delay_std; /* Its standard deviation. [s] */
    double angle_std; /* Noise of the joint angles. [rad] */
    double pressure_offset_std; /* Standard deviation of the zero of a cylinder's pressure. White noise is negligible beside the friction of the seals. [Pa] */
    double angle_offset_std; /* Standard deviation of the zero of a joint angle. [rad] */
    double boom_angle_offset; /* Boom angle that is measured where the true one is 0, as calibrated. [rad] */
    double arm_angle_offset; /* The same of the arm angle. [rad] */
    double bucket_angle_offset; /* The same of the bucket angle. [rad] */
    double swing_velocity_limit; /* A velocity of this size or more is taken as missing (end of the sensor's range). [rad/s] */
    double angle_limit; /* A joint angle of this size or more is taken as missing. [rad] */
    double swing_torque_gain; /* Measured over true swing torque, as calibrated. */
    double swing_torque_offset; /* Swing torque that is measured where there is none, as calibrated. [N m] */
  } sensors;
  struct {
    double inertia; /* Swing inertia. [kg m^2] */
    double inertia_std; /* Its standard deviation. [kg m^2] */
    double payload; /* Payload. [kg] */
    double payload_std; /* Its standard deviation. [kg] */
    double carry_back; /* Carry-back: soil that sticks in an emptied bucket, as a share of the rated payload. */
    double carry_back_std; /* Its standard deviation: nothing to 15 % sticks, mostly little (an exponential distribution). Clay keeps .12 +- .06. From load to load the carry-back varies by 8/7 of it. */
    double damping_std; /* Standard deviation of the damping about nominal_damping (s_b); 0 or the variant "known" say that it is calibrated. [N m s/rad] */
    double torque_offset_std; /* Standard deviation of the torque offset (s_d). [N m] */
    double known_torque_offset_std; /* The same for the variant "known". [N m] */
    double friction_std; /* Standard deviation of the Coulomb friction about coulomb_friction, where it is estimated. [N m] */
  } prior;
  struct {
    double filter_frequency; /* Natural frequency of the common second-order filter of velocity, torque and friction (wn). [rad/s] */
    double filter_damping; /* Its damping ratio (zeta). */
    double q_c; /* Random walk of the acceleration in the Kalman filter, variance per second (q_c; q = q_c T). [rad^2/s^5] */
    double convergence_delay; /* Convergence delay of the Kalman filter, the length of a change window; "none" computes it from the gain. [s] */
    double forgetting[8]; /* Forgetting per sample, one factor or one per parameter; empty takes each method's own. A list replaces paper.lambda_normal and paper.lambda_window. */
    double epsilon; /* Nominal rule: distance of the estimated from the nominal damping at which it acts (Eqs. 28-29). [N m s/rad] */
    double estimate_damping; /* svf-rls estimates the viscous damping too. */
    double estimate_friction; /* svf-rls estimates the Coulomb friction too. */
    double estimate_offset; /* svf-rls estimates a torque offset too. */
    double constant_inertia; /* The caller declares that the inertia does not change (mode A). */
    double variant; /* What is assumed of damping, torque offset and payload. (0 auto, 1 known, 2 tolerant) */
    double friction_width; /* Velocity over which the friction of the joint estimators changes sign. [rad/s] */
    double svf_friction_width; /* The same in svf-rls. [rad/s] */
    double svf_acceleration_min; /* svf-rls learns above this filtered acceleration. [rad/s^2] */
    double svf_covariance; /* Covariance of svf-rls at the start and its largest value. */
    double torque_noise_divisor; /* The torque enters as the mean of two samples, with variance (sigma_T / this)^2; 1, and not 1.41, since each sample is in two means. */
    double torque_noise_share; /* What the model of the torque leaves out, as a share of the largest torque seen (noise per 0.01 s); less or more of it is found from the innovations. */
    double gate; /* Innovations beyond this many standard deviations are weakened. */
    double reject; /* Innovations beyond this many standard deviations are dropped, at most three in a row (modes C, A). */
    double payload_min; /* Smallest payload that an estimate may take. [kg] */
    double payload_max; /* Largest payload that an estimate may take. [kg] */
    double q_m; /* Random walk of the payload: this times 1e-5 of the squared rated payload is its variance per second (q_m). */
    double q_l; /* Random walk of ln J, variance per second (q_l). [1/s] */
    double interval_factor; /* Factor of the reported standard deviation of the method torque, variant "known" (c_I). */
    double calibrate_at_rest; /* Measures the velocity's bias over the first 0.5 s, if the machine stands then. */
    double measure_noise_at_rest; /* Measures the velocity's noise in the same time, within 1 to 4 times the described one. */
    double reopen_after; /* After a stand of this length the payload may be another. [s] */
    double weak_onset; /* Second, more sensitive detector of torque changes (modes C and A with constant inertia). */
    double opening_rate; /* Bucket opening rate that announces a change of payload. [rad/s] */
    double opening_decay; /* Share of the payload that leaves per angle of opening (1.4 per rad). [1/rad] */
    double opening_change_max; /* Largest free change of payload per angle of opening. [kg/rad] */
    double change_rate_std; /* Free change of payload after an alarm and in the second filter. [kg/s] */
    double change_threshold; /* Sum of normalised innovations at which a changed payload is declared. */
    double velocity_drift; /* Random walk of the inertia in mode A, relative. [1/sqrt(s)] */
    double velocity_drift_constant; /* The same with constant_inertia. [1/sqrt(s)] */
    double velocity_torque_drift; /* Random walk of the torque in mode A. [N m/sqrt(s)] */
    double velocity_torque_drift_constant; /* The same with constant_inertia. [N m/sqrt(s)] */
    double excited_velocity; /* Verdict: excited at this velocity. [rad/s] */
    double consistent_nis; /* Verdict: consistent up to this mean of the normalised innovations squared. */
    double converged_share; /* Verdict: converged when the half width of the 95 % interval is below this share of J. */
    double fresh_velocity; /* Verdict: fresh with a velocity at most this old. [s] */
    double fresh_others; /* Verdict: fresh with torque and angles at most this old. [s] */
  } estimator;
  struct {
    double change_times[8]; /* Known times of torque changes; empty finds them online. [s] */
    double lambda_normal[3]; /* Forgetting of inertia, damping and torque outside the change windows. */
    double lambda_window[3]; /* Forgetting of the three inside the change windows. */
    double covariance[3]; /* Initial covariances of the three. */
    double torque; /* Initial torque (the initial inertia and damping are prior.inertia and machine.nominal_damping). [N m] */
    double nominal_rule; /* The nominal-parameter rule for the damping is on. */
    double start_time; /* The regression begins at this time and runs through every standstill from then on; "none" begins with the data and holds at standstill. [s] */
    double stop_time; /* The regression holds its estimate from this time on; "none" goes to the end. [s] */
  } paper;
} heft_excavator_settings;

/* Bytes that heft_excavator_init needs. */
size_t heft_excavator_size(void);

/* Fills in the settings of the reference machine. */
int32_t heft_excavator_defaults(heft_excavator_settings *settings);

/* Sets one key by its name, such as "sensors.rate"; HEFT_NO_SUCH_KEY if there is none, HEFT_REFUSED (and nothing is
 * set) if the key cannot take the value. */
int32_t heft_excavator_set(heft_excavator_settings *settings, const char *key, double value);

/* Gives each key that still has the reference machine's value that of a machine of the stated size (machine.operating_mass, rated_payload and swing_torque, lengths of boom and arm), as
 * a machine file does. Call it once, when all keys that you know are set. HEFT_REFUSED where a key cannot have its value:
 * then nothing is changed. */
int32_t heft_excavator_complete(heft_excavator_settings *settings);

/* What heft_excavator_init calls; other languages give `abi`, HEFT_ABI of the header whose structures they use. */
int32_t heft_excavator_init_as(void *memory, size_t size, const heft_excavator_settings *settings,
                          uint32_t method, uint32_t columns, uint32_t abi);

/* Makes an estimator in the caller's memory (aligned to 8 bytes). `settings` may be NULL for those of
 * the reference machine; they are copied. HEFT_REFUSED: heft_excavator_error tells what is wrong. */
static inline int32_t heft_excavator_init(void *memory, size_t size, const heft_excavator_settings *settings,
                                     uint32_t method, uint32_t columns) {
  return heft_excavator_init_as(memory, size, settings, method, columns, HEFT_ABI);
}

/* Sets all signals of a row to "missing"; then write those that there are. */
int32_t heft_excavator_clear(heft_excavator_sample *sample);

/* Takes one row and answers. A row whose time does not increase is refused: it changes nothing, and the
 * answer has the flag REFUSED. The memory must have been given to heft_excavator_init. */
int32_t heft_excavator_step(void *memory, const heft_excavator_sample *sample, heft_excavator_estimate *estimate);

/* Why the last heft_excavator_init on this memory returned HEFT_REFUSED; "" if it did not. */
const char *heft_excavator_error(const void *memory);

/* Bytes that heft_excavator_save needs. */
size_t heft_excavator_state_size(void);

/* Writes the whole state, settings and method included, to `state`, which may lie anywhere. Between two rows the
 * memory may also be moved by memcpy to another place that is aligned to 8 bytes. */
int32_t heft_excavator_save(const void *memory, void *state, size_t size);

/* Goes on from a saved state, bit for bit; `memory` as for heft_excavator_init, which need not be called. HEFT_REFUSED, and
 * `memory` is as it was: the state is damaged, of another machine, or of another build of the library. */
int32_t heft_excavator_restore(void *memory, size_t size, const void *state, size_t state_size);

/* ---- loader ---- */

/* Methods. */
#define HEFT_LOADER_METHOD_FULL 0
#define HEFT_LOADER_METHOD_ISR_UKF_PRINTED 1
#define HEFT_LOADER_METHOD_ISR_UKF 2
#define HEFT_LOADER_METHOD_EKF 3
#define HEFT_LOADER_METHOD_FULL_EKF 4

/* Reasons: why an estimate is not trusted, or what the machine does beside its description. */
#define HEFT_LOADER_REASON_NONE 0 /* nothing to say */
#define HEFT_LOADER_REASON_MISSING 1 /* an input is missing or too old */
#define HEFT_LOADER_REASON_STUCK_SPEED 2 /* the speed never changes */
#define HEFT_LOADER_REASON_STUCK_FRONT_WHEEL 3 /* the front wheel speed never changes */
#define HEFT_LOADER_REASON_STUCK_REAR_WHEEL 4 /* the rear wheel speed never changes */
#define HEFT_LOADER_REASON_STUCK_FRONT_TORQUE 5 /* the front torque never changes */
#define HEFT_LOADER_REASON_STUCK_REAR_TORQUE 6 /* the rear torque never changes */
#define HEFT_LOADER_REASON_STUCK_SLOPE 7 /* the slope never changes */
#define HEFT_LOADER_REASON_STUCK_ACCELERATION 8 /* the acceleration never changes */
#define HEFT_LOADER_REASON_UNEXPLAINED 9 /* the motion does not follow the model */
#define HEFT_LOADER_REASON_LATENCY 10 /* the speed arrives later than a sensor may */
#define HEFT_LOADER_REASON_STIFFNESS 11 /* the slip stiffness is implausible for a tyre */
#define HEFT_LOADER_REASON_BRAKES 12 /* friction brakes seem to act */
#define HEFT_LOADER_REASON_STEERING 13 /* the machine turns */
#define HEFT_LOADER_REASON_SLOPE 14 /* the slope does not fit the motion */
#define HEFT_LOADER_REASON_TORQUE 15 /* the torques do not fit the motion and the mass */
#define HEFT_LOADER_REASON_LOAD 16 /* the load may have changed */
#define HEFT_LOADER_REASON_DISAGREEMENT 17 /* manoeuvres disagree by more than they claim */
#define HEFT_LOADER_REASON_LIMIT 18 /* an estimate is at its limit */
#define HEFT_LOADER_REASON_RESTARTED 19 /* the service was started again */
#define HEFT_LOADER_REASON_LOCKED_DRIVE 20 /* both axles turn alike: the reported axle torques are not theirs */
#define HEFT_LOADER_REASON_ONE_WAY 21 /* driven one way only: how the tyres give under a load is not known */
#define HEFT_LOADER_REASON_WHEEL_RADIUS 22 /* speed and wheel speeds do not fit the rolling radius that is described */
#define HEFT_LOADER_REASON_LIFT_CYLINDER 23 /* the lift cylinder shows a weight that no bucket holds, or that does not fit emptied buckets or the load's motion */
#define HEFT_LOADER_REASON_ACCELEROMETER 24 /* no accelerometer tells the slope from the acceleration */

/* Name of a reason; empty for none. */
static inline const char *heft_loader_reason(uint32_t code) {
  switch (code) {
    case 0: return "";
    case 1: return "missing";
    case 2: return "stuck speed";
    case 3: return "stuck front wheel";
    case 4: return "stuck rear wheel";
    case 5: return "stuck front torque";
    case 6: return "stuck rear torque";
    case 7: return "stuck slope";
    case 8: return "stuck acceleration";
    case 9: return "unexplained";
    case 10: return "latency";
    case 11: return "stiffness";
    case 12: return "brakes";
    case 13: return "steering";
    case 14: return "slope";
    case 15: return "torque";
    case 16: return "load";
    case 17: return "disagreement";
    case 18: return "limit";
    case 19: return "restarted";
    case 20: return "locked drive";
    case 21: return "one way";
    case 22: return "wheel radius";
    case 23: return "lift cylinder";
    case 24: return "accelerometer";
    default: return "unknown";
  }
}

/* Sensors that the machine has, for `columns` of heft_loader_init; each needs its bit to be used. */
#define HEFT_LOADER_COLUMN_SPEED (1u << 0)
#define HEFT_LOADER_COLUMN_FRONT_WHEEL_SPEED (1u << 1)
#define HEFT_LOADER_COLUMN_REAR_WHEEL_SPEED (1u << 2)
#define HEFT_LOADER_COLUMN_FRONT_TORQUE (1u << 3)
#define HEFT_LOADER_COLUMN_REAR_TORQUE (1u << 4)
#define HEFT_LOADER_COLUMN_SLOPE (1u << 5)
#define HEFT_LOADER_COLUMN_ACCELERATION (1u << 6)
#define HEFT_LOADER_COLUMN_MASS (1u << 7)
#define HEFT_LOADER_COLUMN_SPADE_FORCE_X (1u << 8)
#define HEFT_LOADER_COLUMN_SPADE_FORCE_Z (1u << 9)
#define HEFT_LOADER_COLUMN_BOOM_MOVING (1u << 10)
#define HEFT_LOADER_COLUMN_ARTICULATION (1u << 11)
#define HEFT_LOADER_COLUMN_YAW_RATE (1u << 12)
#define HEFT_LOADER_COLUMN_BRAKE (1u << 13)
#define HEFT_LOADER_COLUMN_LIFT_ANGLE (1u << 14)
#define HEFT_LOADER_COLUMN_TILT_ANGLE (1u << 15)
#define HEFT_LOADER_COLUMN_LIFT_HEAD_PRESSURE (1u << 16)
#define HEFT_LOADER_COLUMN_LIFT_ROD_PRESSURE (1u << 17)
#define HEFT_LOADER_COLUMN_TRUCK (1u << 18)

/* Bits of `flags` of an estimate. */
#define HEFT_LOADER_FLAG_EXCITED_RATIO (1u << 0)
#define HEFT_LOADER_FLAG_EXCITED_HEIGHT (1u << 1)
#define HEFT_LOADER_FLAG_CONSISTENT (1u << 2)
#define HEFT_LOADER_FLAG_FRESH (1u << 3)
#define HEFT_LOADER_FLAG_CONVERGED_RATIO (1u << 4)
#define HEFT_LOADER_FLAG_CONVERGED_HEIGHT (1u << 5)
#define HEFT_LOADER_FLAG_FROZEN (1u << 6)
#define HEFT_LOADER_FLAG_RESET (1u << 7)
#define HEFT_LOADER_FLAG_TRUSTED_RATIO (1u << 8)
#define HEFT_LOADER_FLAG_TRUSTED_HEIGHT (1u << 9)
#define HEFT_LOADER_FLAG_REFUSED (1u << 10)
#define HEFT_LOADER_FLAG_DIVERGED (1u << 11)
#define HEFT_LOADER_FLAG_IDENTIFIABLE_RATIO (1u << 12)
#define HEFT_LOADER_FLAG_IDENTIFIABLE_HEIGHT (1u << 13)
#define HEFT_LOADER_FLAG_RESTARTED (1u << 14)
#define HEFT_LOADER_FLAG_TRUSTED_PAYLOAD (1u << 15)
#define HEFT_LOADER_FLAG_CHANGING (1u << 16)
#define HEFT_LOADER_FLAG_OF_EMPTY (1u << 17)

/* Bits of `estimated` of an estimate: which quantities the method has an opinion on. */
#define HEFT_LOADER_ESTIMATED_STATE (1u << 0)
#define HEFT_LOADER_ESTIMATED_SPADE_FORCE_X (1u << 1)
#define HEFT_LOADER_ESTIMATED_SLOPE_BIAS (1u << 2)
#define HEFT_LOADER_ESTIMATED_RADIUS_SCALES (1u << 3)
#define HEFT_LOADER_ESTIMATED_SPEED_DELAY (1u << 4)
#define HEFT_LOADER_ESTIMATED_PAYLOAD (1u << 5)

/* A row of sensors; NAN where a sample is missing. */
typedef struct {
  double t; /* Time of the measurement, by the clock of the data. [s] */
  double speed; /* Forward speed of the body. [m/s] */
  double front_wheel_speed; /* Speed of the front wheels. [rad/s] */
  double rear_wheel_speed; /* Speed of the rear wheels. [rad/s] */
  double front_torque; /* Front axle torque at the wheels, total. [N m] */
  double rear_torque; /* Rear axle torque at the wheels, total. [N m] */
  double slope; /* Slope of the frame, nose up positive, in reverse too. [rad] */
  double acceleration; /* Specific force along the body axis, dv/dt + g sin(slope). [m/s^2] */
  double mass; /* Mass of the machine with its load. [kg] */
  double spade_force_x; /* Force on the bucket tip that pushes the machine backward. [N] */
  double spade_force_z; /* Force on the bucket tip that pushes the machine down. [N] */
  double boom_moving; /* Above 0 while the boom moves; 0 or NAN: it rests. */
  double articulation; /* Angle between front and rear body, positive when the machine turns left. [rad] */
  double yaw_rate; /* Yaw rate of the rear body, positive anticlockwise from above. [rad/s] */
  double brake; /* Above 0 while friction brakes act; 0 or NAN: they do not. */
  double lift_angle; /* Angle of the lift arm to the machine's frame, 0 where it is level on level ground, up positive. [rad] */
  double tilt_angle; /* Angle of the bucket relative to the lift arm, tip up positive. [rad] */
  double lift_head_pressure; /* Pressure at the head side of the lift cylinders, their mean. [Pa] */
  double lift_rod_pressure; /* Pressure at the rod side of the lift cylinders, their mean. [Pa] */
  double truck; /* Number of the truck that is loaded; another number begins the next truck. */
} heft_loader_sample;

/* The answer to a row. */
typedef struct {
  double t; /* Time of the measurement, by the clock of the data. [s] */
  double speed; /* Forward speed. [m/s] */
  double front_wheel_speed; /* Speed of the front wheels. [rad/s] */
  double rear_wheel_speed; /* Speed of the rear wheels. [rad/s] */
  double slip_stiffness; /* Slip stiffness of the tyres, F_x = K slip F_z. */
  double slip_stiffness_std; /* Standard deviation of `slip_stiffness`, as reported. */
  double cg_height; /* Height of the centre of gravity above ground. [m] */
  double cg_height_std; /* Standard deviation of `cg_height`, as reported. [m] */
  double cg_ratio; /* Share of the static weight on the front axle. */
  double cg_ratio_std; /* Standard deviation of `cg_ratio`, as reported. */
  double cg_distance; /* Distance from the front axle to the centre of gravity. [m] */
  double spade_force_x; /* Horizontal spade force, measured plus unknown. [N] */
  double spade_force_x_std; /* Standard deviation of `spade_force_x`, as reported. [N] */
  double slope_bias; /* Bias of the slope sensor (true slope = measured - bias). [rad] */
  double front_radius_scale; /* Rolling radius of the front wheels over its nominal value. */
  double rear_radius_scale; /* Rolling radius of the rear wheels over its nominal value. */
  double nis; /* Normalised innovation squared of this sample per accepted measurement. */
  double speed_delay; /* Delay of the measured speed. [s] */
  double speed_delay_std; /* Standard deviation of `speed_delay`, as reported. [s] */
  double payload; /* Payload. [kg] */
  double payload_std; /* Standard deviation of `payload`, as reported. [kg] */
  uint64_t refused; /* Rows refused so far. */
  uint32_t flags; /* HEFT_LOADER_FLAG_... */
  uint32_t estimated; /* HEFT_LOADER_ESTIMATED_... */
  uint32_t method; /* HEFT_LOADER_METHOD_..., the one at work. */
  uint32_t reason; /* HEFT_LOADER_REASON_...: why it is not trusted, or what the machine does beside its description; 0 for none. */
} heft_loader_estimate;

/* Settings, as in a description; flags are 0 or 1, choices count from 0, NAN is "none" and ends a list. */
typedef struct {
  struct {
    double mass; /* Mass, where the data do not carry one. [kg] */
    double wheel_radius; /* Rolling radius at the nominal axle load. [m] */
    double axle_inertia; /* Inertia of an axle with its wheels and drive, at the wheel. [kg m^2] */
    double wheelbase; /* Distance of the axles (l). [m] */
    double bucket_reach; /* Front axle to bucket tip (l_c). [m] */
    double rolling_resistance; /* Rolling resistance (f). */
    double gear_ratio; /* Motor to wheel; used by the simulator, torques in the data are those at the wheel. */
    double friction; /* Largest tyre force over axle load (mu); 0 leaves it unlimited. */
    double radius_load_sensitivity; /* Relative loss of rolling radius per relative axle load (rho). */
    double radius_load_sensitivity_std; /* Its standard deviation, from tyre to tyre where nobody measured it (anything between a rigid tyre and twice the usual one); widens the reported interval of the ratio until the machine has driven both ways. */
    double stiffness_ratio; /* Slip stiffness of the front axle over that of the rear under equal loads, as calibrated. */
    double stiffness_ratio_std; /* Standard deviation of the ratio of the axles' slip stiffnesses; widens the reported interval of the ratio. */
    double stiffness_load_exponent; /* p, where the slip stiffness falls with the load F_z as F_z^-p, as calibrated. */
    double stiffness_load_exponent_std; /* Standard deviation of p where the slip stiffness falls with the load F_z as F_z^-p; widens the reported interval of the height. */
    double relaxation_length; /* Relaxation length of the tyres; 0 for tyres that do not wind up. [m] */
  } machine;
  struct {
    double length; /* Pivot of the arm to the bucket's pin; 0 where no arm is described, and pressures are not used. [m] */
    double length_std; /* Its standard deviation. [m] */
    double pivot_x; /* Pivot ahead of the front axle, negative behind it. [m] */
    double pivot_x_std; /* Its standard deviation. [m] */
    double pivot_z; /* Pivot above the ground. [m] */
    double pivot_z_std; /* Its standard deviation. [m] */
    double mass; /* Mass of the arm; 0 for 6 % of the machine's, known to a quarter. [kg] */
    double mass_std; /* Its standard deviation. [kg] */
    double mass_distance; /* Pivot to the arm's centre of mass; 0 for .54 of the length, known to 10 %. [m] */
    double mass_distance_std; /* Its standard deviation. [m] */
    double bucket_mass; /* Mass of the empty bucket; 0 for 6.5 % of the machine's, known to 40 %. [kg] */
    double bucket_mass_std; /* Its standard deviation. [kg] */
    double payload_distance; /* Bucket's pin to the centre of the load, and of the bucket; 0 for .23 of the arm's length, known to a fifth. [m] */
    double payload_distance_std; /* Its standard deviation. [m] */
    double bucket_turn; /* How far the bucket turns with the arm while nobody tilts, in angles of the arm: 1 with the tilt cylinder on the arm; with the cylinder on the frame 0 for parallel lift, .1 to .3 for a Z-bar; "none" holds both cylinders for possible. */
    double bucket_turn_std; /* Its standard deviation; 0 for .05. */
    double reference_angle; /* Arm angle at which the empty machine's centre of gravity is stated, up from the horizontal. [rad] */
    double reference_tilt; /* Tilt angle at which it is stated, bucket to arm. [rad] */
    double empty_mass; /* Mass of the empty machine; 0 for `machine.mass`. [kg] */
    double empty_mass_std; /* Its standard deviation; 0 for 2 % of it. [kg] */
    double empty_ratio; /* Share of its weight on the front axle; 0 for `prior.cg_ratio`. */
    double empty_ratio_std; /* Its standard deviation; 0 for `prior.cg_ratio_std`. */
    double empty_height; /* Height of its centre of gravity; 0 for `prior.cg_height`. [m] */
    double empty_height_std; /* Its standard deviation; 0 for `prior.cg_height_std`. [m] */
    double arm_cos; /* Moment about the pivot that the drawing misses: with the cosine of the arm's angle to the horizontal. [N m] */
    double arm_sin; /* With its sine. [N m] */
    double bucket_cos; /* With the cosine of the bucket's angle to the horizontal. [N m] */
    double bucket_sin; /* With its sine. [N m] */
  } lift_arm;
  struct {
    double count; /* How many. */
    double head_area; /* Area of the head side of one. [m^2] */
    double head_area_std; /* Its standard deviation. [m^2] */
    double rod_area; /* Area of the rod side of one. [m^2] */
    double rod_area_std; /* Its standard deviation. [m^2] */
    double base_distance; /* Base of the cylinder to the arm's pivot. [m] */
    double base_distance_std; /* Its standard deviation. [m] */
    double rod_distance; /* Arm's pivot to the eye of the rod. [m] */
    double rod_distance_std; /* Its standard deviation. [m] */
    double angle; /* Angle between both at arm angle 0. [rad] */
    double angle_std; /* Its standard deviation. [rad] */
    double friction; /* Friction of the seals, as a share of the force of 20 MPa on the head side. */
    double friction_std; /* Its standard deviation. */
    double force_offset; /* Force that the pressures show too much, by the zeros of their sensors. [N] */
    double force_offset_std; /* Its standard deviation; 0 for that of the sensors' zeros. [N] */
    double span_std; /* Relative standard deviation of the moment, as calibrated; 0 for those of areas, distances, angles and masses. */
    double span_offset_correlation; /* Correlation of the errors of force offset and span. */
  } cylinder;
  struct {
    double rate; /* Samples per second. [Hz] */
    double speed_std; /* Noise of the speed. [m/s] */
    double wheel_speed_std; /* Noise of the wheel speeds. [rad/s] */
    double slope_std; /* Noise of the slope. [rad] */
    double acceleration_std; /* Noise of the specific force. [m/s^2] */
    double acceleration_offset; /* Specific force that the accelerometer shows where there is none (its zero, and gravity where it is mounted askew), as calibrated. [m/s^2] */
    double acceleration_offset_std; /* Its standard deviation; widens the reported interval of the ratio. [m/s^2] */
    double front_torque_gain; /* Measured over true torque of the front axle, as calibrated. */
    double rear_torque_gain; /* Measured over true torque of the rear axle, as calibrated. */
    double torque_gain_std; /* Standard deviation of each axle's torque gain; widens the reported interval of the ratio. */
    double speed_delay; /* Delay of the speed against the other signals (satellite receivers, radars); `full` learns it. [s] */
    double speed_delay_std; /* Its standard deviation before the first row. [s] */
    double slope_delay; /* Delay of the slope against the other signals: the time constant of an inclinometer, as calibrated. [s] */
    double slope_delay_std; /* Its standard deviation, from which a calibration starts; on line the errors of the slope show in the motion. [s] */
    double slope_acceleration_sensitivity; /* Share of the acceleration that the slope sensor takes for a slope, as calibrated; acts where an accelerometer tells it. */
    double slope_acceleration_sensitivity_std; /* Its standard deviation, from which a calibration starts. */
    double pressure_std; /* Noise of the cylinder pressures. [Pa] */
    double pressure_offset_std; /* Standard deviation of the zero of each pressure sensor. [Pa] */
    double pressure_gain_std; /* Standard deviation of the gain of the cylinder pressures about 1: range, unit, what a sensor lost. A calibrated span holds it. */
    double angle_offset_std; /* Standard deviation of the zeros of lift and tilt angle; 0.009 (half a degree) where somebody set them. [rad] */
  } sensors;
  struct {
    double slip_stiffness; /* Slip stiffness (K). */
    double slip_stiffness_std; /* Its standard deviation. */
    double cg_height; /* Height of the centre of gravity (h). [m] */
    double cg_height_std; /* Its standard deviation. [m] */
    double cg_ratio; /* Share of the static weight on the front axle (lambda). */
    double cg_ratio_std; /* Its standard deviation. */
    double speed_std; /* Standard deviation of the speed at the start. [m/s] */
    double wheel_speed_std; /* Standard deviation of the wheel speeds at the start. [rad/s] */
    double spade_force_std; /* Standard deviation of the unmeasured spade force at the start. [N] */
    double front_radius_error; /* Relative error of the front rolling radius, as calibrated. */
    double rear_radius_error; /* Relative error of the rear rolling radius, as calibrated. */
    double radius_std; /* Standard deviation of the relative radius errors at the start; 5e-4 when calibrated. */
    double slope_bias; /* Slope that the sensor shows on level ground, as calibrated. [rad] */
    double slope_bias_std; /* Standard deviation of the slope bias at the start. [rad] */
  } prior;
  struct {
    double load_transfer; /* Sign of the dynamic load transfer. (0 physical, 1 printed) */
    double tuning; /* Configuration of the methods isr-ukf-printed, isr-ukf and ekf. (0 paper, 1 tuned) */
    double inputs; /* Inputs of a step. (0 auto, 1 midpoint, 2 hold) */
    double substeps; /* Equal sub-steps per row. */
    double alpha; /* Spread of the sigma points (the tuning "paper" has 0.01). */
    double beta; /* Weight of the centre point in the covariance. */
    double kappa; /* Second spread of the sigma points. */
    double q_speed; /* Random walk of the speed. [m/s] */
    double q_wheel_speed; /* Random walk of the wheel speeds. [rad/s] */
    double q_slip_stiffness; /* Random walk of the slip stiffness. */
    double q_cg_height; /* Random walk of the height. [m] */
    double q_cg_ratio; /* Random walk of the ratio. */
    double q_spade_force; /* Random walk of the unmeasured spade force. [N] */
    double q_radius; /* Random walk of the radius errors. */
    double q_slope_bias; /* Least random walk of the slope bias; errors of the slope that the motion shows add to it. [rad] */
    double q_speed_delay; /* Random walk of the delay of the speed. [s] */
    double v_min; /* Smallest speed in a slip denominator. [m/s] */
    double v_freeze; /* Parameters are frozen below this speed. [m/s] */
    double c_b; /* Wheel-speed noise from axle-load ripple acting through the slip, share of the slip (cb). */
    double c_rho; /* Wheel-speed noise from axle-load ripple acting through the radius (crho). */
    double c_t; /* Wheel-speed noise from changes of torque (ct). */
    double gate; /* Innovations beyond this many standard deviations are weakened. */
    double reject; /* Innovations beyond this many standard deviations are dropped. */
    double slip_stiffness_min; /* Smallest slip stiffness. */
    double slip_stiffness_max; /* Largest slip stiffness. */
    double cg_height_min; /* Smallest height. [m] */
    double cg_height_max; /* Largest height. [m] */
    double cg_ratio_min; /* Smallest ratio. */
    double cg_ratio_max; /* Largest ratio. */
    double reset_nis; /* Mean normalised innovation squared at which the filter is reset. */
    double gap; /* A longer step between rows is a gap: speed and wheel speeds are taken anew. [s] */
    double dig_force; /* Spade force that means digging; parameters are frozen. [N] */
    double dig_hold; /* Digging lasts at least this long. [s] */
    double reopen; /* Height and ratio are reopened after digging to this many prior standard deviations; 0 leaves them. */
    double relearn; /* Once the ratio is known the parameters are loosened, because the start was linearised at the initial guess: share of the prior that comes back per squared standard deviation of way; 0 is off. */
    double boom_gain; /* The boom moves: random walks of height and ratio times this. */
    double cg_height_floor; /* What cannot be learnt of the height; added to its reported standard deviation. [m] */
    double cg_ratio_floor; /* What cannot be learnt of the ratio, relative; added to its reported standard deviation. */
    double load_sensitivity_floor; /* Least error of the load sensitivity of the rolling radius that counts, whatever is stated; 0 when calibrated. */
    double excited_torque; /* Verdict: the ratio is excited when the torque varies by this (standard deviation over 5 s). [N m] */
    double excited_acceleration; /* Verdict: the height is excited when the acceleration varies by this. [m/s^2] */
    double fresh; /* Verdict: fresh with every needed input at most this old. [s] */
    double consistent_nis; /* Verdict: consistent up to this mean normalised innovation squared. */
    double converged_ratio; /* Verdict: the ratio has converged at this relative standard deviation. */
    double converged_height; /* Verdict: the height has converged at this standard deviation. [m] */
  } estimator;
} heft_loader_settings;

/* Bytes that heft_loader_init needs. */
size_t heft_loader_size(void);

/* Fills in the settings of the reference machine. */
int32_t heft_loader_defaults(heft_loader_settings *settings);

/* Sets one key by its name, such as "sensors.rate"; HEFT_NO_SUCH_KEY if there is none, HEFT_REFUSED (and nothing is
 * set) if the key cannot take the value. */
int32_t heft_loader_set(heft_loader_settings *settings, const char *key, double value);

/* Gives each key that still has the reference machine's value that of a machine of the stated size (machine.mass, wheel_radius, prior.cg_height), as
 * a machine file does. Call it once, when all keys that you know are set. HEFT_REFUSED where a key cannot have its value:
 * then nothing is changed. */
int32_t heft_loader_complete(heft_loader_settings *settings);

/* What heft_loader_init calls; other languages give `abi`, HEFT_ABI of the header whose structures they use. */
int32_t heft_loader_init_as(void *memory, size_t size, const heft_loader_settings *settings,
                          uint32_t method, uint32_t columns, uint32_t abi);

/* Makes an estimator in the caller's memory (aligned to 8 bytes). `settings` may be NULL for those of
 * the reference machine; they are copied. HEFT_REFUSED: heft_loader_error tells what is wrong. */
static inline int32_t heft_loader_init(void *memory, size_t size, const heft_loader_settings *settings,
                                     uint32_t method, uint32_t columns) {
  return heft_loader_init_as(memory, size, settings, method, columns, HEFT_ABI);
}

/* Sets all signals of a row to "missing"; then write those that there are. */
int32_t heft_loader_clear(heft_loader_sample *sample);

/* Takes one row and answers. A row whose time does not increase is refused: it changes nothing, and the
 * answer has the flag REFUSED. The memory must have been given to heft_loader_init. */
int32_t heft_loader_step(void *memory, const heft_loader_sample *sample, heft_loader_estimate *estimate);

/* Why the last heft_loader_init on this memory returned HEFT_REFUSED; "" if it did not. */
const char *heft_loader_error(const void *memory);

/* Bytes that heft_loader_save needs. */
size_t heft_loader_state_size(void);

/* Writes the whole state, settings and method included, to `state`, which may lie anywhere. Between two rows the
 * memory may also be moved by memcpy to another place that is aligned to 8 bytes. */
int32_t heft_loader_save(const void *memory, void *state, size_t size);

/* Goes on from a saved state, bit for bit; `memory` as for heft_loader_init, which need not be called. HEFT_REFUSED, and
 * `memory` is as it was: the state is damaged, of another machine, or of another build of the library. */
int32_t heft_loader_restore(void *memory, size_t size, const void *state, size_t state_size);

/* ---- loads of either machine ---- */

/* Bits of `flags`. */
#define HEFT_LOADS_FLAG_TRUSTED 1u /* The mass of the load may be believed. */
#define HEFT_LOADS_FLAG_CARRIED 2u /* The load is in the bucket. */
#define HEFT_LOADS_FLAG_FINAL 4u /* The load was dumped: its mass does not change any more. */
#define HEFT_LOADS_FLAG_CARRY_BACK_WEIGHED 8u /* What stayed in the bucket was weighed after this load; else it is the mean of earlier ones. */
#define HEFT_LOADS_FLAG_WEIGHED 16u /* The bucket was weighed at least once, `payload_age` ago. */
#define HEFT_LOADS_FLAG_TRUCK_TRUSTED 32u /* The truck has loads, and each of them may be believed. */
#define HEFT_LOADS_FLAG_HAS_TARGET 64u /* Somebody said what the truck shall hold. */
#define HEFT_LOADS_FLAG_OUTAGE 128u /* A fault of a sensor left no load weighed for more than a tenth of the run: loads may be missing in the sums. */

/* Codes of `stage`. */
#define HEFT_LOADS_STAGE_CARRIED 0 /* In the bucket; its mass becomes better. */
#define HEFT_LOADS_STAGE_DUMPED 1 /* Its mass is final, what stays in the bucket is not weighed yet. */
#define HEFT_LOADS_STAGE_SETTLED 2 /* What stays in the bucket is final too. */

/* Codes of `witness`. */
#define HEFT_LOADS_WITNESS_MOTION 0 /* How the machine accelerates. */
#define HEFT_LOADS_WITNESS_PRESSURE 1 /* Cylinder pressures. */
#define HEFT_LOADS_WITNESS_MOTION_AND_PRESSURE 2 /* Both, in one state. */
#define HEFT_LOADS_WITNESS_SCALE 3 /* A scale on the machine: its mass is measured. */
#define HEFT_LOADS_WITNESS_NOTHING 4 /* Nothing: the bucket was seen to open, and the mass is what a load may be. */

/* A row: an estimate of either machine, each of them once. */
typedef struct {
  double t; /* Time of the estimate; rows must increase [s] */
  double payload; /* NAN where nothing estimates it [kg] */
  double payload_std; /* Its standard deviation [kg] */
  double speed; /* Swing rate [rad/s] or driving speed [m/s], of any sign; NAN: not known */
  double truck; /* Which truck is loaded: another value begins another truck; NAN: not known */
  uint32_t trusted; /* 1: the payload may be believed */
  uint32_t changing; /* 1: the content is changing */
  uint32_t reason; /* Why it is not trusted, in the machine's codes: carried along */
  uint32_t witness; /* HEFT_LOADS_WITNESS_... */
} heft_loads_row;

/* What is known after it. */
typedef struct {
  double payload; /* What the bucket holds now: always a value, the last known one where nothing weighs it. [kg] */
  double payload_std; /* Its standard deviation, which grows with time and by what may have changed. [kg] */
  double payload_age; /* Time since it was last weighed; 1e9 if it never was. [s] */
  double mass; /* The latest load: what was in the bucket. [kg] */
  double mass_std; /* Its standard deviation. [kg] */
  double common_std; /* The part of `mass_std` that all loads share: it does not average out. [kg] */
  double carry_back; /* What stayed in the bucket. [kg] */
  double carry_back_std; /* Its standard deviation. [kg] */
  double delivered; /* What the truck got of this load. [kg] */
  double delivered_std; /* Its standard deviation. [kg] */
  double filled; /* Since when the bucket is known to hold the load. [s] */
  double dumped; /* When it began to leave; 0 while it is carried. [s] */
  double truck_mass; /* What the truck holds. [kg] */
  double truck_mass_std; /* Its standard deviation. [kg] */
  double target; /* What the truck shall hold; 0 if nobody said. [kg] */
  double remaining; /* What is missing to the target, negative where there is too much; 0 without a target. [kg] */
  uint32_t load; /* Number of the latest load, from 1; 0 before the first one. */
  uint32_t truck; /* Number of the truck that is being loaded, from 1. */
  uint32_t truck_loads; /* Loads that it holds. */
  uint32_t truck_untrusted; /* Of them those that may not be believed. */
  uint32_t stage; /* Code of how far the load has come. */
  uint32_t witness; /* Code of the source of its mass. */
  uint32_t reason; /* Code of the reason why it is not trusted. */
  uint32_t flags; /* Bits of this message. */
} heft_loads;

/* Bytes that heft_loads_init needs. */
size_t heft_loads_size(void);

/* What heft_loads_init calls. */
int32_t heft_loads_init_as(void *memory, size_t size, double rated, double target, double pause, uint32_t abi);

/* Makes an empty book in the caller's memory (aligned to 8 bytes). `rated`: payload of a full bucket, roughly [kg];
 * `target`: what a truck shall hold, NAN if nobody says [kg]; `pause`: a load this long after the one before goes to
 * another truck, 0 never, NAN: 300 [s]. HEFT_REFUSED: one of them is impossible. Nothing is known of what all loads are off
 * together: their sums look better than they are. heft_excavator_loads_init and heft_loader_loads_init know it. */
static inline int32_t heft_loads_init(void *memory, size_t size, double rated, double target, double pause) {
  return heft_loads_init_as(memory, size, rated, target, pause, HEFT_ABI);
}

/* Takes an estimate. `payload` of the answer is always a value: the last known one, with a deviation that grows. */
int32_t heft_loads_step(void *memory, const heft_loads_row *row, heft_loads *loads);

/* Begins another truck: what is dumped from now on goes there. */
int32_t heft_loads_next_truck(void *memory, heft_loads *loads);

/* What this truck and the next ones shall hold from now on [kg]; NAN: nobody says. HEFT_REFUSED: no weight, and nothing
 * changes. */
int32_t heft_loads_set_target(void *memory, double target, heft_loads *loads);

/* What heft_excavator_loads_init calls. */
int32_t heft_excavator_loads_init_as(void *memory, size_t size, const heft_excavator_settings *settings, double target,
                                double pause, uint32_t abi);

/* heft_loads_init for the machine of these settings, those that heft_excavator_init was given: the payload of a full bucket, and
 * what all of its loads are off together, follow from them. `settings` may be NULL for the reference machine.
 * HEFT_REFUSED: a setting, `target` or `pause` is impossible. */
static inline int32_t heft_excavator_loads_init(void *memory, size_t size, const heft_excavator_settings *settings, double target,
                                           double pause) {
  return heft_excavator_loads_init_as(memory, size, settings, target, pause, HEFT_ABI);
}

/* What heft_loader_loads_init calls. */
int32_t heft_loader_loads_init_as(void *memory, size_t size, const heft_loader_settings *settings, double target,
                                double pause, uint32_t abi);

/* heft_loads_init for the machine of these settings, those that heft_loader_init was given: the payload of a full bucket, and
 * what all of its loads are off together, follow from them. `settings` may be NULL for the reference machine.
 * HEFT_REFUSED: a setting, `target` or `pause` is impossible. */
static inline int32_t heft_loader_loads_init(void *memory, size_t size, const heft_loader_settings *settings, double target,
                                           double pause) {
  return heft_loader_loads_init_as(memory, size, settings, target, pause, HEFT_ABI);
}

#ifdef __cplusplus
}
#endif

#endif
