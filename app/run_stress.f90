!> Stress below the surface at the end of a solve: options --depths and --stress.
module asperity_run_stress
  use asperity_contact_field, only: contact_field
  use asperity_csv_tables, only: begin_stress_csv, write_stress_csv
  use asperity_decimal, only: decimal_to_real64
  use asperity_kinds, only: real64
  use asperity_map_stress, only: largest_stress, look_for_largest, stress_solver
  use asperity_number_format, only: number_text
  use asperity_problems, only: problem_list
  use asperity_scene_values, only: scene
  use asperity_text_buffer, only: text_buffer
  use asperity_unit_names, only: is_length, is_pressure, unit_of, with_unit
  implicit none
  private

  public :: check_stress, compute_stress

contains

  !> Reports a scene whose material does not determine the stress.
  subroutine check_stress(scene_in, problems)
    type(scene), intent(in) :: scene_in            !! scene, checked for faults
    type(problem_list), intent(inout) :: problems  !! list; gets a line for such a scene

    if (decimal_to_real64(scene_in%contact_modulus) > 0.0_real64) &
      call problems%add('--depths: stress needs poisson_ratio in &material: found ' // &
                        'contact_modulus in its place')
  end subroutine check_stress

  !> Computes the stress in the lower body at all depths: the largest ones as lines of text, all
  !> components as a table.
  subroutine compute_stress(scene_in, field, depths, text, table, units)
    type(scene), intent(in) :: scene_in            !! scene, for ratio and units
    type(contact_field), intent(in) :: field       !! pressures of the last state
    real(real64), intent(in) :: depths(:)          !! depths below the surface, more than 0
    type(text_buffer), intent(inout) :: text       !! gets two lines
    type(text_buffer), intent(inout), optional :: table  !! gets the table; absent: none
    character(len=*), intent(in), optional :: units      !! line before the table
    character(len=*), parameter :: names(2) = [character(len=20) :: 'von Mises stress', &
      'largest shear stress']
    type(stress_solver) :: solver
    type(largest_stress) :: largest(2)
    real(real64), allocatable :: stress(:, :, :)
    character(len=:), allocatable :: line
    integer :: k

    call solver%prepare(field, decimal_to_real64(scene_in%lower%poisson_ratio))
    if (present(table)) call begin_stress_csv(table, units)
    do k = 1, size(depths)
      call solver%solve(depths(k), stress)
      call look_for_largest(field, depths(k), stress, largest)
      if (present(table)) call write_stress_csv(field, depths(k), stress, table)
    end do
    call text%line('')
    call text%line('Stress in the lower body under the normal pressures, largest of the depths')
    do k = 1, size(largest)
      line = '  ' // with_unit(trim(names(k)), trim(unit_of(scene_in, is_pressure))) // ' ' // &
             number_text(largest(k)%value) // ' at depth ' // number_text(largest(k)%depth) // &
             ', x ' // number_text(largest(k)%x) // ', y ' // number_text(largest(k)%y)
      call text%line(with_unit(line, trim(unit_of(scene_in, is_length))))
    end do
  end subroutine compute_stress

end module asperity_run_stress
