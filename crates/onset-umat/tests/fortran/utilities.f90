! For tests: a UMAT that passes its properties to the routines of Abaqus and stores their results in the state variables.
! PROPS(1:6) a stress, PROPS(7) = 1 to call XIT, 2 for an error of STDB_ABQERR.
subroutine umat(stress, statev, ddsdde, sse, spd, scd, rpl, ddsddt, drplde, drpldt, stran, dstran, time, dtime, temp, dtemp, &
                predef, dpred, cmname, ndi, nshr, ntens, nstatv, props, nprops, coords, drot, pnewdt, celent, dfgrd0, dfgrd1, &
                noel, npt, layer, kspt, jstep, kinc)
  implicit none
  integer, intent(in) :: ndi, nshr, ntens, nstatv, nprops, noel, npt, layer, kspt, jstep(4), kinc
  character(len=80), intent(in) :: cmname
  double precision, intent(inout) :: stress(ntens), statev(nstatv), ddsdde(ntens, ntens), sse, spd, scd, rpl, pnewdt
  double precision, intent(inout) :: ddsddt(ntens), drplde(ntens), drpldt
  double precision, intent(in) :: stran(ntens), dstran(ntens), time(2), dtime, temp, dtemp, predef(*), dpred(*)
  double precision, intent(in) :: props(nprops), coords(3), drot(3, 3), celent, dfgrd0(3, 3), dfgrd1(3, 3)
  character(len=256) :: folder
  character(len=8) :: words(1)
  integer :: length, numbers(1)
  double precision :: reals(1)

  call sinv(props, statev(1), statev(2), ndi, nshr)
  call sprinc(props, statev(3), 1, ndi, nshr)
  call sprind(props, statev(6), statev(9), 1, ndi, nshr)
  call rotsig(props, drot, statev(18), 1, ndi, nshr)
  call getoutdir(folder, length)
  statev(24) = length
  ! SDVINI has set the initial value.
  statev(25) = 2.0d0*statev(25)
  ddsdde = 0.0d0
  words(1) = 'here'
  numbers(1) = noel
  reals(1) = 0.5d0
  if (nint(props(7)) == 1) call xit
  if (nint(props(7)) == 2) call stdb_abqerr(-3, 'element %I has %R %S', numbers, reals, words)
end subroutine umat

subroutine sdvini(statev, coords, nstatv, ncrds, noel, npt, layer, kspt)
  implicit none
  integer, intent(in) :: nstatv, ncrds, noel, npt, layer, kspt
  double precision, intent(inout) :: statev(nstatv)
  double precision, intent(in) :: coords(ncrds)
  statev(nstatv) = 21.0d0
end subroutine sdvini
