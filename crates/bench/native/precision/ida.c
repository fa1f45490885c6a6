/* IDA of SUNDIALS in the index-1 form (constraints on accelerations), y = (q, v, lambda):
 *
 *   0 = q' - v,   0 = M v' - f + G^T lambda,   0 = G v' + gamma
 *
 * with its dense solver and the difference quotients that it takes by itself. The functions used are declared here, after its manual, so that the run-time libraries
 * are enough: link with libsundials_ida and libsundials_nvecserial, version 6. */
#include "driver.h"

#define N (2 * NQ + NC)

typedef struct context *SUNContext;
typedef struct vector *N_Vector;
typedef struct matrix *SUNMatrix;
typedef struct linear_solver *SUNLinearSolver;
typedef int residual(double t, N_Vector y, N_Vector ydot, N_Vector out, void *user);
int SUNContext_Create(void *comm, SUNContext *);
int SUNContext_Free(SUNContext *);
N_Vector N_VMake_Serial(long n, double *, SUNContext);
double *N_VGetArrayPointer_Serial(N_Vector);
void N_VDestroy_Serial(N_Vector);
SUNMatrix SUNDenseMatrix(long rows, long cols, SUNContext);
void SUNMatDestroy(SUNMatrix);
SUNLinearSolver SUNLinSol_Dense(N_Vector, SUNMatrix, SUNContext);
int SUNLinSolFree(SUNLinearSolver);
void *IDACreate(SUNContext);
int IDAInit(void *, residual *, double t, N_Vector y, N_Vector ydot);
int IDASStolerances(void *, double rtol, double atol);
int IDASetLinearSolver(void *, SUNLinearSolver, SUNMatrix);
int IDASetId(void *, N_Vector);
int IDASetSuppressAlg(void *, int);
int IDASetMaxNumSteps(void *, long);
int IDASetStopTime(void *, double);
int IDASetErrFile(void *, FILE *);
int IDASolve(void *, double t_out, double *t, N_Vector y, N_Vector ydot, int task);
int IDAGetIntegratorStats(void *, long *n_step, long *n_residual, long *n_factor, long *n_reject,
                          int *, int *, double *, double *, double *, double *);
int IDAGetNumJacEvals(void *, long *);
int IDAGetNumLinResEvals(void *, long *);
void IDAFree(void **);

static int equations(double t, N_Vector y_, N_Vector ydot_, N_Vector out_, void *user) {
    (void)user;
    const double *y = N_VGetArrayPointer_Serial(y_), *ydot = N_VGetArrayPointer_Serial(ydot_);
    double *out = N_VGetArrayPointer_Serial(out_);
    const double *lambda = y + 2 * NQ, *a = ydot + NQ;
    struct terms at;
    terms(t, y, y + NQ, &at);
    for (int i = 0; i < NQ; i++) {
        out[i] = ydot[i] - y[NQ + i];
        double force = -at.force[i];
        for (int j = 0; j < NQ; j++) force += at.mass[i][j] * a[j];
        for (int k = 0; k < NC; k++) force += at.jacobian[k][i] * lambda[k];
        out[NQ + i] = force;
    }
    for (int k = 0; k < NC; k++) {
        out[2 * NQ + k] = at.gamma[k];
        for (int i = 0; i < NQ; i++) out[2 * NQ + k] += at.jacobian[k][i] * a[i];
    }
    return 0;
}

static struct end integrate(const struct start *start, double tolerance) {
    enum { NORMAL = 1 };
    double y[N], ydot[N] = {0}, id[N], t = 0;
    memcpy(y, start->q, sizeof start->q);
    memcpy(y + NQ, start->v, sizeof start->v);
    memcpy(y + 2 * NQ, start->lambda, sizeof start->lambda);
    memcpy(ydot, start->v, sizeof start->v);
    memcpy(ydot + NQ, start->a, sizeof start->a);
    for (int i = 0; i < N; i++) id[i] = i < 2 * NQ;

    SUNContext context;
    SUNContext_Create(NULL, &context);
    N_Vector state = N_VMake_Serial(N, y, context), rate = N_VMake_Serial(N, ydot, context);
    N_Vector differential = N_VMake_Serial(N, id, context);
    SUNMatrix matrix = SUNDenseMatrix(N, N, context);
    SUNLinearSolver solver = SUNLinSol_Dense(state, matrix, context);
    void *ida = IDACreate(context);
    IDAInit(ida, equations, 0, state, rate);
    IDASetErrFile(ida, NULL);
    IDASStolerances(ida, tolerance, tolerance);
    IDASetLinearSolver(ida, solver, matrix);
    IDASetId(ida, differential);
    IDASetSuppressAlg(ida, 1);
    IDASetMaxNumSteps(ida, 2000000);
    IDASetStopTime(ida, start->t_end);
    const int outcome = IDASolve(ida, start->t_end, &t, state, rate, NORMAL);

    struct end end = {.is_reached = outcome >= 0 && t == start->t_end};
    int order;
    double h;
    long n_difference = 0;
    IDAGetIntegratorStats(ida, &end.n_step, &end.n_residual, &end.n_factor, &end.n_reject, &order,
                          &order, &h, &h, &h, &h);
    IDAGetNumJacEvals(ida, &end.n_jacobian);
    IDAGetNumLinResEvals(ida, &n_difference);
    end.n_residual += n_difference;
    memcpy(end.q, y, sizeof end.q);
    memcpy(end.v, y + NQ, sizeof end.v);
    memcpy(end.lambda, y + 2 * NQ, sizeof end.lambda);
    IDAFree(&ida);
    SUNLinSolFree(solver);
    SUNMatDestroy(matrix);
    N_VDestroy_Serial(state);
    N_VDestroy_Serial(rate);
    N_VDestroy_Serial(differential);
    SUNContext_Free(&context);
    return end;
}

int main(void) { return measure(); }
