/* evaluate() for a function that CasADi wrote: one vector in, one vector out. */
#define N_WORK 65536

int casadi_f(const double **arg, double **res, long long *iw, double *w, int mem);

void evaluate(const double *inputs, double *outputs) {
    static double w[N_WORK];
    static long long iw[N_WORK];
    const double *arg[16] = {inputs};
    double *res[16] = {outputs};
    casadi_f(arg, res, iw, w, 0);
}
