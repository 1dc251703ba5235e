/* One call after another over the same states, for functions that are known by their address.
 *
 * The loop is that of pinocchio_cpp: the first number of each result goes into a sum, times are those of the
 * processor for this process. All return nanoseconds a call. */
#include <time.h>

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

static volatile double sink;

/* x, y, z: rows of one state after the other, of n_x, n_y, n_z numbers. */
typedef int (*symbody)(const double *, const double *, const double *, const double *, const double *,
                       const double *, double *, double *);

double time_symbody(symbody f, long count, const double *q, long n_q, const double *u, long n_u,
                    const double *r, long n_r, const double *c, double *out, double *work) {
    const double t = 0;
    const double start = now();
    double sum = 0;
    for (long k = 0; k < count; ++k) {
        f(&t, q + k * n_q, u + k * n_u, r + k * n_r, 0, c, out, work);
        sum += out[0];
    }
    const double took = now() - start;
    sink = sum;
    return took / (double)count;
}

typedef int (*casadi)(const double **, double **, long long *, double *, int);

double time_casadi(casadi f, long count, const double *q, long n_q, const double *v, long n_v, const double *x,
                   long n_x, double **out, const double **arguments, long long *iw, double *w) {
    const double start = now();
    double sum = 0;
    for (long k = 0; k < count; ++k) {
        arguments[0] = q + k * n_q, arguments[1] = v + k * n_v, arguments[2] = x + k * n_x;
        f(arguments, out, iw, w, 0);
        sum += out[0][0];
    }
    const double took = now() - start;
    sink = sum;
    return took / (double)count;
}

typedef void (*mujoco)(const void *, void *);

double time_mujoco(mujoco f, const void *model, void *data, long count, const double *q, long n_q,
                   const double *u, long n_u, const double *x, double *to_q, double *to_u, double *to_x,
                   const double *result) {
    const double start = now();
    double sum = 0;
    for (long k = 0; k < count; ++k) {
        for (long i = 0; i < n_q; ++i) to_q[i] = q[k * n_q + i];
        for (long i = 0; i < n_u; ++i) to_u[i] = u[k * n_u + i];
        for (long i = 0; i < n_u; ++i) to_x[i] = x[k * n_u + i];
        f(model, data);
        sum += result[0];
    }
    const double took = now() - start;
    sink = sum;
    return took / (double)count;
}
