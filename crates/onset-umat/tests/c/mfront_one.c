/* The law of Blatz and Ko with the symbols and structures of MFront's generic interface, as in the headers BehaviourData.h and State.h of TFEL. */
#include "../../c/blatz_ko_law.c"
#include <string.h>

typedef struct {
    const double *gradients;
    double *thermodynamic_forces;
    const double *mass_density, *material_properties;
    double *internal_state_variables, *stored_energy, *dissipated_energy;
    const double *external_state_variables;
} State;

typedef struct {
    char *error_message;
    double dt, *K, *rdt, *speed_of_sound;
    State s0, s1;
} BehaviourData;

#define BEHAVIOR(NAME, INTERFACE, TYPE, KINEMATIC)                                                                                \
    const char *NAME##_mfront_ept = #NAME;                                                                                          \
    const char *NAME##_mfront_interface = INTERFACE;                                                                                \
    unsigned short NAME##_BehaviourType = TYPE, NAME##_BehaviourKinematic = KINEMATIC;                                              \
    unsigned short NAME##_nMaterialProperties = 1;                                                                                  \
    const char *NAME##_MaterialProperties[] = {"ShearModulus"};                                                                     \
    unsigned short NAME##_nInternalStateVariables = 2;                                                                              \
    int NAME##_InternalStateVariablesTypes[] = {1, 0};

/* Places in a tensor stored by rows of 11, 22, 33, 12, 21, 13, 31, 23, 32. */
static const int ROWS[9] = {0, 4, 8, 1, 3, 2, 6, 5, 7};

/* Its state variables are the right Cauchy-Green tensor, with the factor sqrt(2) on shear, and the number of increments. */
static int integrate(BehaviourData *d)
{
    double start[9], end[9], piola[9], tangent[81], energy;
    for (int n = 0; n < 9; n++)
        start[ROWS[n]] = d->s0.gradients[n], end[ROWS[n]] = d->s1.gradients[n];
    const int is_asked = d->K[0] == 4 && d->K[1] == 2 && d->K[2] == 2;
    const int has_temperature = d->s1.external_state_variables[0] == 293.15;
    if (!is_asked || !has_temperature) {
        strcpy(d->error_message, "not called as MGIS calls a behavior");
        return -1;
    }
    onset_law(start, end, 0, d->dt, d->s1.material_properties, 1, 0, 0, &energy, piola, tangent);
    for (int n = 0; n < 9; n++) {
        d->s1.thermodynamic_forces[n] = piola[ROWS[n]];
        for (int m = 0; m < 9; m++)
            d->K[9 * n + m] = tangent[9 * ROWS[n] + ROWS[m]];
    }
    *d->s1.stored_energy = energy;
    *d->s1.dissipated_energy = *d->s0.dissipated_energy + d->dt;
    for (int n = 0; n < 6; n++) {
        static const int pairs[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};
        double sum = 0;
        for (int i = 0; i < 3; i++)
            sum += end[3 * i + pairs[n][0]] * end[3 * i + pairs[n][1]];
        d->s1.internal_state_variables[n] = n < 3 ? sum : 1.4142135623730951 * sum;
    }
    d->s1.internal_state_variables[6] = d->s0.internal_state_variables[6] + 1;
    return 1;
}

BEHAVIOR(BlatzKo, "Generic", 2, 3)

int BlatzKo_Tridimensional(BehaviourData *d)
{
    return integrate(d);
}
