/* The pendulum of pendulum.py in C, without a JSON library: requests have a fixed form.
   Build: cc -O2 examples/pipe/pendulum.c -o pendulum -lm
   Run:   sindyna train --task-file examples/pipe/pendulum.toml --pipe ./pendulum */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define DT 0.05
#define STEPS 4

static double theta = 3.141592653589793, omega = 0.0;

static double acceleration(double angle, double rate, double u) { return 9.81 * sin(angle) - 0.1 * rate + u; }

static void step(double u) {
    double h = DT / STEPS;
    for (int i = 0; i < STEPS; i++) {
        double a = omega, b = acceleration(theta, a, u);
        double c = omega + h / 2 * b, d = acceleration(theta + h / 2 * a, c, u);
        double e = omega + h / 2 * d, f = acceleration(theta + h / 2 * c, e, u);
        double g = omega + h * f, k = acceleration(theta + h * e, g, u);
        theta += h / 6 * (a + 2 * c + 2 * e + g);
        omega += h / 6 * (b + 2 * d + 2 * f + k);
    }
}

int main(void) {
    char line[4096];
    while (fgets(line, sizeof line, stdin)) {
        char *values = strchr(line, '[');
        if (strstr(line, "\"type\":\"close\"")) {
            return 0;
        } else if (strstr(line, "\"type\":\"spec\"")) {
            printf("{\"states\": [\"\xce\xb8\", \"\xcf\x89\"], \"controls\": [\"u\"], \"dt\": %g}\n", DT);
        } else if (strstr(line, "\"type\":\"reset\"") && values) {
            char *end;
            theta = strtod(values + 1, &end);
            omega = strtod(end + 1, NULL);
            printf("{\"state\": [%.17g, %.17g]}\n", theta, omega);
        } else if (strstr(line, "\"type\":\"step\"") && values) {
            step(strtod(values + 1, NULL));
            printf("{\"state\": [%.17g, %.17g]}\n", theta, omega);
        } else {
            printf("{\"error\": \"unknown request\"}\n");
        }
        fflush(stdout);
    }
    return 0;
}
