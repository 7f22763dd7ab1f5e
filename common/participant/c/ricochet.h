/* Take part in a coupled run of ricochet from C, or from whatever calls C: for codes that own their time loop.
 *
 *   ricochet_loop* loop = ricochet_open("explicit", "my code", 2);
 *   ... ricochet_add_body, ricochet_set_interface, ricochet_add_column, ...
 *   error = ricochet_initialize(loop, value, record);
 *   while (ricochet_ongoing(loop)) {
 *     if (ricochet_must_save(loop)) keep a copy of the state;
 *     ricochet_read(loop, link);
 *     compute a window of the size ricochet_max_time_step(loop), at whose end `link` acts;
 *     ricochet_write(loop, value, velocity, acceleration, record);
 *     ricochet_advance(loop);
 *     if (ricochet_must_restore(loop)) take the copy back;
 *   }
 *   return ricochet_close(loop);
 *
 * The library is libricochet.so; ricochet.f90 beside this file says the same to Fortran. Link with -lricochet.
 *
 * Units are SI. Arrays named value, velocity, acceleration, link and position hold one row per interface node, in the
 * order of ricochet_set_interface, and in it one number per displacement component: number c of node i, both counted
 * from 0, stands at i * components + c. (In Fortran that is an array (components, nodes).)
 *
 * An *explicit* participant is given the displacement of its interface nodes [m] and answers the force P = K u [N] that
 * resists it there. An *implicit* one, and an explicit one that is driven by force, integrates its interface nodes: it
 * is given a force [N] and answers displacement [m], velocity [m/s] and acceleration [m/s^2]. The force is L with
 * M a = f - K u - L for the implicit one, lambda with M a = f - K u + lambda for the one driven by force.
 *
 * Functions that return `int error` return 0, or else the exit code that the program is to end with: 2 its input or its
 * calls are wrong, 3 numbers went wrong, 4 a participant or the coupler failed, 5 the protocol was broken, 7 the
 * machine lacks something. A line that says what is wrong stands on standard error then. One thread calls, the library
 * has another that talks with the coupler while this one waits. Texts end with a null character and are copied. */
#ifndef RICOCHET_H
#define RICOCHET_H

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ricochet_loop ricochet_loop;

/* Begins a participant. Its name and the address of the coupler are taken from the command line of this process,
 * --name, --connect, --key, --scene, --watch-stdin, as the coupler appends them; there may be no others.
 * `role`: "explicit" or "implicit". `solver`: the name of this program in messages. `components`: displacement
 * components per node, 1 to 3. NULL: it failed, end the program with exit code 2. */
ricochet_loop* ricochet_open(const char* role, const char* solver, int components);

/* Path of the scene file, and its name there; valid until ricochet_close. The first is "" if there was no --scene. */
const char* ricochet_scene(const ricochet_loop* loop);
const char* ricochet_name(const ricochet_loop* loop);

/* The program describes itself, before ricochet_initialize. Return: int error. */

/* A body of the scene that it has elements of; bodies are counted from 0 in the order of these calls. */
int ricochet_add_body(ricochet_loop* loop, const char* body);
/* For each of `nodes` interface nodes: index of its body, position in the reference configuration [m], and the lumped
 * mass of this participant's elements alone [kg]. `body` and `mass` have `nodes` numbers, `position` nodes x components. */
int ricochet_set_interface(ricochet_loop* loop, int nodes, const int* body, const double* position, const double* mass);
/* Limit of its own explicit integration [s]; without this call none is known. */
int ricochet_set_critical_time_step(ricochet_loop* loop, double step_s);
/* "repeat_window": it saves and restores when asked to; "driven_by_force": it can be;
 * "reconfigure": every window may have another size, it asks ricochet_max_time_step for that of each. (docs/participants.md) */
int ricochet_add_capability(ricochet_loop* loop, const char* capability);
/* A column of the history, "<quantity>/<body>"; `record` has as many numbers as these calls. (docs/participants.md) */
int ricochet_add_column(ricochet_loop* loop, const char* column);

/* Meets the coupler. `value`: force or displacement at t = 0, nodes x components; `record`: history row at t = 0.
 * Return: int error. */
int ricochet_initialize(ricochet_loop* loop, const double* value, const double* record);

/* The coupler's settings; after ricochet_initialize. */

/* Size of the window to come [s]; with the capability "reconfigure" it may change between windows. */
double ricochet_window_size(const ricochet_loop* loop);
/* Explicit, driven by force: central difference steps in a window, over which lambda is linear. */
int ricochet_substeps(const ricochet_loop* loop);
/* 1: its link input is a force, 0: a displacement. */
int ricochet_driven_by_force(const ricochet_loop* loop);
/* Per interface node the mass to integrate it with [kg], `nodes` numbers: summed over all participants, or its own
 * under a dual protocol. Return: int error. */
int ricochet_interface_mass(const ricochet_loop* loop, double* mass);

/* The unit vectors n, t and, of solids, b along which momenta, impulses and contact forces are told, components x
 * components numbers, one vector after the other. Return: int error. */
int ricochet_directions(const ricochet_loop* loop, double* directions);
/* Where the scene has the interface nodes [m], nodes x components. Return: int error. */
int ricochet_scene_position(const ricochet_loop* loop, double* position);

/* Tells what a set-up is doing that may take longer than the scene's timeout_s, and the share of it that is done, 0
 * to 1 (< 0: nobody knows). The coupler shows it and waits anew from then on. Only between ricochet_initialize and the first
 * question about the time loop. Return: int error. */
int ricochet_progress(ricochet_loop* loop, const char* doing, double share_done);

/* The time loop. */

/* 1: there is a window to compute. 0: the run is over or has failed, which ricochet_close tells. */
int ricochet_ongoing(const ricochet_loop* loop);
/* Size of the window to compute [s]. 0: new accelerations from the link values that are read, nothing else moves. */
double ricochet_max_time_step(const ricochet_loop* loop);
/* 1: a new window begins, and the coupler may ask for it again: keep a copy. Needs the capability "repeat_window". */
int ricochet_must_save(const ricochet_loop* loop);
/* 1: what was computed since then is void: take the copy back. */
int ricochet_must_restore(const ricochet_loop* loop);
/* Link input at the end of the window, nodes x components: displacement [m] or force [N]. Return: int error. */
int ricochet_read(const ricochet_loop* loop, double* link);
/* Answers what holds at the end of the window: `value` nodes x components, force [N] or displacement [m]; `velocity` [m/s] and
 * `acceleration` [m/s^2] as many, NULL if driven by displacement; `record` the history row. Return: int error.
 */
int ricochet_write(ricochet_loop* loop, const double* value, const double* velocity, const double* acceleration,
                   const double* record);
/* The window is computed: exchanges, and waits for what is next. Return: int error. */
int ricochet_advance(ricochet_loop* loop);

/* Waits for the end of the conversation and forgets the loop. Before the end of the run: the coupler is told that the
 * solver left, and ends it. Return: int error, of the whole run: the exit code of the program. */
int ricochet_close(ricochet_loop* loop);

#ifdef __cplusplus
}
#endif
#endif
