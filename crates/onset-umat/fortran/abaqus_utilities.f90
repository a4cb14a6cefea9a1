! The routines that Abaqus offers to user subroutines, for UMATs that call them outside of Abaqus. Compile this file together
! with the UMAT:
!
!   gfortran -shared -fPIC -O2 -o umat.so umat.f utilities.f90
!
! Tensors are vectors of NDI direct and NSHR shear components, in the order 11, 22, 33, 12, 13, 23. LSTR tells stresses (1) from
! strains (2), whose shear components are doubled.

module onset_abaqus_utilities
  implicit none
  private
  public :: matrix_of, principal

contains

  ! The symmetric matrix of a vector.
  pure function matrix_of(s, lstr, ndi, nshr) result(matrix)
    double precision, intent(in) :: s(*)
    integer, intent(in) :: lstr, ndi, nshr
    double precision :: matrix(3, 3), factor
    integer, parameter :: first(3) = [1, 1, 2], second(3) = [2, 3, 3]
    integer :: n
    factor = merge(0.5d0, 1.0d0, lstr == 2)
    matrix = 0.0d0
    do n = 1, ndi
      matrix(n, n) = s(n)
    end do
    do n = 1, nshr
      matrix(first(n), second(n)) = factor*s(ndi + n)
      matrix(second(n), first(n)) = factor*s(ndi + n)
    end do
  end function matrix_of

  ! Principal values and, in rows, directions of a symmetric matrix, by Jacobi's rotations.
  pure subroutine principal(matrix, values, directions)
    double precision, intent(in) :: matrix(3, 3)
    double precision, intent(out) :: values(3), directions(3, 3)
    double precision :: a(3, 3), turn(3, 3), angle
    integer :: sweep, p, q
    a = matrix
    directions = 0.0d0
    do p = 1, 3
      directions(p, p) = 1.0d0
    end do
    do sweep = 1, 50
      if (abs(a(1, 2)) + abs(a(1, 3)) + abs(a(2, 3)) == 0.0d0) exit
      do p = 1, 2
        do q = p + 1, 3
          angle = 0.5d0*atan2(2.0d0*a(p, q), a(p, p) - a(q, q))
          if (a(p, q) == 0.0d0) cycle
          turn = 0.0d0
          turn(1, 1) = 1.0d0
          turn(2, 2) = 1.0d0
          turn(3, 3) = 1.0d0
          turn(p, p) = cos(angle)
          turn(q, q) = cos(angle)
          turn(p, q) = sin(angle)
          turn(q, p) = -sin(angle)
          a = matmul(turn, matmul(a, transpose(turn)))
          a(p, q) = 0.0d0
          a(q, p) = 0.0d0
          directions = matmul(turn, directions)
        end do
      end do
    end do
    do p = 1, 3
      values(p) = a(p, p)
    end do
  end subroutine principal
end module onset_abaqus_utilities

! The first two invariants: the mean value and von Mises' equivalent.
subroutine sinv(stress, sinv1, sinv2, ndi, nshr)
  use onset_abaqus_utilities
  implicit none
  integer, intent(in) :: ndi, nshr
  double precision, intent(in) :: stress(*)
  double precision, intent(out) :: sinv1, sinv2
  double precision :: deviator(3, 3)
  integer :: i
  deviator = matrix_of(stress, 1, ndi, nshr)
  sinv1 = (deviator(1, 1) + deviator(2, 2) + deviator(3, 3))/3.0d0
  do i = 1, 3
    deviator(i, i) = deviator(i, i) - sinv1
  end do
  sinv2 = sqrt(1.5d0*sum(deviator**2))
end subroutine sinv

! Principal values.
subroutine sprinc(s, ps, lstr, ndi, nshr)
  use onset_abaqus_utilities
  implicit none
  integer, intent(in) :: lstr, ndi, nshr
  double precision, intent(in) :: s(*)
  double precision, intent(out) :: ps(3)
  double precision :: directions(3, 3)
  call principal(matrix_of(s, lstr, ndi, nshr), ps, directions)
end subroutine sprinc

! Principal values and directions: AN(K1, 1..3) are the direction cosines of PS(K1).
subroutine sprind(s, ps, an, lstr, ndi, nshr)
  use onset_abaqus_utilities
  implicit none
  integer, intent(in) :: lstr, ndi, nshr
  double precision, intent(in) :: s(*)
  double precision, intent(out) :: ps(3), an(3, 3)
  call principal(matrix_of(s, lstr, ndi, nshr), ps, an)
end subroutine sprind

! A tensor turned by R: R S R^T.
subroutine rotsig(s, r, sprime, lstr, ndi, nshr)
  use onset_abaqus_utilities
  implicit none
  integer, intent(in) :: lstr, ndi, nshr
  double precision, intent(in) :: s(*), r(3, 3)
  double precision, intent(out) :: sprime(*)
  double precision :: turned(3, 3), factor
  integer, parameter :: first(3) = [1, 1, 2], second(3) = [2, 3, 3]
  integer :: n
  turned = matrix_of(s, lstr, ndi, nshr)
  turned = matmul(turned, transpose(r))
  turned = matmul(r, turned)
  factor = merge(2.0d0, 1.0d0, lstr == 2)
  do n = 1, ndi
    sprime(n) = turned(n, n)
  end do
  do n = 1, nshr
    sprime(ndi + n) = factor*turned(first(n), second(n))
  end do
end subroutine rotsig

! The end of the analysis: of this process, which onset reports.
subroutine xit
  implicit none
  write (0, '(a)') 'the UMAT called XIT'
  flush (0)
  stop 1
end subroutine xit

! A message (LOP 1), a warning (-1), an error that goes on (-2) or ends (-3); %I, %R and %S stand for the arguments.
subroutine stdb_abqerr(lop, string, intv, realv, charv)
  implicit none
  integer, intent(in) :: lop, intv(*)
  character(len=*), intent(in) :: string
  double precision, intent(in) :: realv(*)
  character(len=8), intent(in) :: charv(*)
  character(len=24) :: word
  integer :: at, next(3)
  next = 1
  at = 1
  do while (at <= len_trim(string))
    word = ''
    if (string(at:at) == '%' .and. at < len(string)) then
      select case (string(at + 1:at + 1))
      case ('I', 'i')
        write (word, '(i0)') intv(next(1))
        next(1) = next(1) + 1
      case ('R', 'r')
        write (word, '(g0)') realv(next(2))
        next(2) = next(2) + 1
      case ('S', 's')
        word = charv(next(3))
        next(3) = next(3) + 1
      end select
    end if
    if (word == '') then
      write (0, '(a)', advance='no') string(at:at)
      at = at + 1
    else
      write (0, '(a)', advance='no') trim(adjustl(word))
      at = at + 2
    end if
  end do
  write (0, '(a)') ''
  flush (0)
  if (lop == -3) call xit
end subroutine stdb_abqerr

! The folder in which onset was started; files named without it are written to a folder that is removed in the end.
subroutine getoutdir(outdir, lenoutdir)
  implicit none
  character(len=*), intent(out) :: outdir
  integer, intent(out) :: lenoutdir
  call get_environment_variable('ONSET_UMAT_DIRECTORY', outdir, lenoutdir)
end subroutine getoutdir

! The name of the job.
subroutine getjobname(jobname, lenjobname)
  implicit none
  character(len=*), intent(out) :: jobname
  integer, intent(out) :: lenjobname
  jobname = 'onset'
  lenjobname = 5
end subroutine getjobname

! The number of processes: each serves one point at a time.
subroutine getnumcpus(numprocesses)
  implicit none
  integer, intent(out) :: numprocesses
  numprocesses = 1
end subroutine getnumcpus

! The number of this process.
subroutine getrank(kprocessnum)
  implicit none
  integer, intent(out) :: kprocessnum
  kprocessnum = 0
end subroutine getrank
